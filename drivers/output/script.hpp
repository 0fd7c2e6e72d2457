// The scripts in drivers/python, which draw what the program has computed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ductile::drivers {

/// How a script has ended.
struct ScriptEnding {
  int code = 0;           ///< the program's exit code: 0, 1, or 2 where its input is wrong
  std::string complaint;  ///< where it has failed: one line
};

/// Whether a script hears what the terminal sends to the program.
enum class Session {
  shared,
  /// It goes on if this program is killed, as by what kills a job a second after it was told to
  /// end.
  own,
};

/// Runs a script, `name` in drivers/python, with the system's /usr/bin/python3, and waits for its
/// end. What it prints on stdout goes there; of stderr the last line is the complaint. It is found
/// beside the installed program (../share/ductile/python), else in the source directory. Starts a
/// process, which MPI does not like while it is up: call after MPI_Finalize unless there is no time
/// for that.
ScriptEnding run_script(std::string_view name, std::vector<std::string> words, Session session);

/// A command whose whole work is a script's: runs it in the program's session, so that what ends
/// the program from the terminal ends it too, says its complaint on stderr, and gives its exit
/// code.
int carry_out(std::string_view name, std::vector<std::string> words);

}  // namespace ductile::drivers
