#include "output/plot.hpp"

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "output/say.hpp"
#include "output/script.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view script = "plot.py";

/// Draws at the end of a run, which says nothing unless it fails.
bool draw_quietly(const fs::path& directory, std::string_view name, std::string_view format) {
  const ScriptEnding ended = run_script(
      script, {"--quiet", "--format", std::string(format), "--", directory.string()}, Session::own);
  if (ended.code == 0) return true;
  say(stderr, "warning: no {}.{}: {}\n", name, format, ended.complaint);
  return false;
}

}  // namespace

int draw(const Picture& picture) {
  std::vector<std::string> words;
  if (!picture.format.empty()) words.insert(words.end(), {"--format", picture.format});
  if (!picture.file.empty()) words.push_back("--output=" + picture.file.string());
  if (picture.map) words.emplace_back("--map");
  words.emplace_back("--");
  for (const fs::path& directory : picture.directories) words.push_back(directory.string());
  const ScriptEnding ended = run_script(script, std::move(words), Session::own);
  if (ended.code != 0) say(stderr, "{}\n", ended.complaint);
  return ended.code;
}

bool plot_trajectory(const fs::path& directory, std::string_view format) {
  return draw_quietly(directory, "trajectory", format);
}

bool plot_comparison(const fs::path& directory, std::string_view format) {
  return draw_quietly(directory, "compare", format);
}

}  // namespace ductile::drivers
