#include "fuzz/inputs.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "campaign/sweep.hpp"
#include "checks/read_case.hpp"
#include "commands/pair.hpp"
#include "commands/program.hpp"
#include "output/checkpoint.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers::fuzz {

void scenario(std::string_view bytes) {
  try {
    const Case given = parse_case(bytes, "fuzz.toml");
    // What is accepted is accepted again as it is written down.
    const std::string text = resolved_toml(given.scenario);
    if (!(parse_case(text, "resolved.toml").scenario == given.scenario))
      throw std::logic_error("the resolved scenario is another");
  } catch (const InputError&) {
    return;
  }
}

void command_line(std::string_view bytes) {
  std::vector<std::string> arguments;
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    arguments.emplace_back(bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    if (!arguments.empty()) static_cast<void>(parsed_duration(arguments.back()));
  }
  try {
    const CommandLine line(arguments);
    // Others read a file of any name.
    if (const auto* pair = dynamic_cast<PairCommand*>(line.command())) {
      static_cast<void>(pair->max_walltime());
      static_cast<void>(pair->prepare());
    }
  } catch (const InputError&) {
    return;
  }
}

void campaign(std::string_view bytes) {
  try {
    const Sweep sweep = parse_sweep(bytes, "fuzz.toml");
    for (const SweptCase& swept : sweep.cases) {
      if (swept.name.empty() || swept.name.find('/') != std::string::npos ||
          swept.name.starts_with('.') || swept.values.size() != sweep.axes.size())
        throw std::logic_error("a case that has no directory");
    }
    // One of many is enough.
    static_cast<void>(
        parse_case(sweep.cases.back().text, sweep.cases.back().file, sweep.cases.back().overrides));
  } catch (const InputError&) {
    return;
  }
}

void checkpoint(std::string_view bytes) {
  static const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("ductile_fuzz_" + std::to_string(getpid()) + ".h5");
  {
    std::ofstream out(file, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  bool accepted = false;
  try {
    const Checkpoint whole(file);
    accepted = true;
    static_cast<void>(whole.text("scenario"));
    static_cast<void>(whole.numbers("record/steps"));
    static_cast<void>(whole.numbers("state/fluid/time"));
  } catch (const CheckpointError&) {
  }
  std::filesystem::remove(file);
  if (accepted) throw std::logic_error("passes for a checkpoint");
}

}  // namespace ductile::drivers::fuzz
