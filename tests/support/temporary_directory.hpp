// A directory of a test's own.
#pragma once

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace ductile::testing_support {

/// Empty, under the system's directory for such, and gone with all that is in it at the end.
class TemporaryDirectory {
 public:
  /// Throws std::system_error.
  TemporaryDirectory() {
    // mkdtemp() wants six of these at the end, and puts letters in their place.
    std::string name =
        (std::filesystem::temp_directory_path() / ("ductile-" + std::string(6, 'X'))).string();
    if (mkdtemp(name.data()) == nullptr)
      throw std::system_error(errno, std::generic_category(), name);
    path_ = name;
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace ductile::testing_support
