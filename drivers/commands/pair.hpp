// `ductile pair`: one of the paper's pairs.
#pragma once

#include <string>
#include <vector>

#include "commands/run.hpp"

namespace ductile::drivers {

class PairCommand final : public SingleRun {
 public:
  PairCommand();
  CLI::App* declare(CLI::App& program) override;
  [[nodiscard]] Request prepare() const override;

 private:
  /// An option that stands for a key.
  struct Shorthand {
    std::string option;
    std::string key;
    std::string meaning;
    std::string value;
    const CLI::Option* given = nullptr;
  };
  std::string pair_;
  std::vector<Shorthand> shorthands_;
};

}  // namespace ductile::drivers
