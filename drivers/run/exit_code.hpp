// The exit codes of the program, as `ductile --help` documents them.
#pragma once

namespace ductile::drivers {

enum ExitCode : int {
  exit_success = 0,
  exit_failure = 1,      ///< the run could not be done: a full disk, no memory, a solver's failure
  exit_bad_input = 2,    ///< wrong usage or a wrong scenario; nothing was written
  exit_blow_up = 3,      ///< the fluid or a body became unstable
  exit_contact = 4,      ///< surfaces of bodies crossed, or a body came to a wall
  exit_interrupted = 5,  ///< a signal ended the run
  exit_walltime = 6      ///< the run has used up its --max-walltime
};

}  // namespace ductile::drivers
