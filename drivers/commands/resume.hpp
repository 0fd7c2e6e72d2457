// `ductile resume`: a run that has ended, however it ended, goes on.
#pragma once

#include <string>

#include "commands/run.hpp"

namespace ductile::drivers {

class ResumeCommand final : public SingleRun {
 public:
  CLI::App* declare(CLI::App& program) override;
  /// The case of the directory's scenario.toml.
  [[nodiscard]] Request prepare() const override;
  [[nodiscard]] bool resumes() const override { return true; }

 private:
  std::string directory_;
  std::string until_;
  CLI::Option* until_given_ = nullptr;
};

}  // namespace ductile::drivers
