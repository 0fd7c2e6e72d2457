#include "output/version.hpp"

#include <fmt/format.h>
#include <hdf5.h>
#include <mpi.h>
#include <petscsys.h>
#include <toml++/toml.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <array>
#include <string_view>

#include "ductile/instruction_set.hpp"

namespace ductile::drivers {

std::vector<std::pair<std::string, std::string>> versions() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> mpi{};
  int length = 0;
  if (MPI_Get_library_version(mpi.data(), &length) != MPI_SUCCESS) length = 0;
  // Open MPI goes on about the package and its date.
  std::string_view mpi_text(mpi.data(), static_cast<std::size_t>(length));
  mpi_text = mpi_text.substr(0, mpi_text.find_first_of(",\n"));

  PetscInt major = 0;
  PetscInt minor = 0;
  PetscInt patch = 0;
  PetscInt release = 0;
  if (PetscGetVersionNumber(&major, &minor, &patch, &release) != 0) major = 0;
  unsigned hdf5_major = 0;
  unsigned hdf5_minor = 0;
  unsigned hdf5_patch = 0;
  if (H5get_libversion(&hdf5_major, &hdf5_minor, &hdf5_patch) < 0) hdf5_major = 0;

#ifdef __clang__
  const std::string compiler = fmt::format("clang {}", __clang_version__);
#else
  const std::string compiler = fmt::format("g++ {}", __VERSION__);
#endif
  return {{"ductile", DUCTILE_VERSION},
          {"kernel", std::string(name(best_instruction_set()))},
          {"compiler", compiler},
          {"MPI", std::string(mpi_text)},
          {"PETSc", fmt::format("{}.{}.{}", major, minor, patch)},
          {"HDF5", fmt::format("{}.{}.{}", hdf5_major, hdf5_minor, hdf5_patch)},
          {"Eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"toml++", fmt::format("{}.{}.{}", TOML_LIB_MAJOR, TOML_LIB_MINOR, TOML_LIB_PATCH)},
          {"CLI11", CLI11_VERSION},
          {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                              FMT_VERSION % 100)}};
}

}  // namespace ductile::drivers
