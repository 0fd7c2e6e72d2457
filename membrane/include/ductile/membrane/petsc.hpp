// PETSc in C++ terms: owners that destroy, array access that restores, error codes that throw.
#pragma once

#include <petscsnes.h>

#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>
#include <type_traits>

namespace ductile::membrane {

static_assert(std::is_same_v<PetscScalar, double>, "ductile needs PETSc in real double precision");

/// From now on PETSc prints nothing when it fails; PetscFailure says what it would have printed.
/// Not collective; call once, after PetscInitialize().
void quieten_petsc();

/// A PETSc call returned an error code.
class PetscFailure : public std::runtime_error {
 public:
  PetscFailure(PetscErrorCode code, const char* file, int line);
  [[nodiscard]] PetscErrorCode code() const { return code_; }

 private:
  PetscErrorCode code_;
};

/// Throws PetscFailure unless `code` is success. Not for functions that PETSc calls: there no
/// exception may leave. The defaults are the caller's place (std::source_location is beyond clang
/// 14).
inline void petsc_check(PetscErrorCode code, const char* file = __builtin_FILE(),
                        int line = __builtin_LINE()) {
  if (code != 0) throw PetscFailure(code, file, line);
}

struct VecDestroyer {
  void operator()(Vec vec) const noexcept { static_cast<void>(VecDestroy(&vec)); }
};
/// Owner of a Vec; must go before PetscFinalize().
using VecPtr = std::unique_ptr<std::remove_pointer_t<Vec>, VecDestroyer>;

struct MatDestroyer {
  void operator()(Mat mat) const noexcept { static_cast<void>(MatDestroy(&mat)); }
};
/// Owner of a Mat; must go before PetscFinalize().
using MatPtr = std::unique_ptr<std::remove_pointer_t<Mat>, MatDestroyer>;

struct KspDestroyer {
  void operator()(KSP ksp) const noexcept { static_cast<void>(KSPDestroy(&ksp)); }
};
using KspPtr = std::unique_ptr<std::remove_pointer_t<KSP>, KspDestroyer>;

struct SnesDestroyer {
  void operator()(SNES snes) const noexcept { static_cast<void>(SNESDestroy(&snes)); }
};
using SnesPtr = std::unique_ptr<std::remove_pointer_t<SNES>, SnesDestroyer>;

/// A vector of zeros on PETSC_COMM_SELF: three numbers, interlaced, for each of `vertex_count`
/// vertices; block size 3.
VecPtr create_vec(int vertex_count);

/// The numbers of a sequential Vec while this object lives; T is double or const double (read
/// only).
template <class T>
class VecArray {
  static constexpr bool read_only = std::is_const_v<T>;

 public:
  explicit VecArray(Vec vec) : vec_(vec) {
    PetscInt size = 0;
    petsc_check(VecGetLocalSize(vec, &size));
    size_ = static_cast<std::size_t>(size);
    if constexpr (read_only) {
      petsc_check(VecGetArrayRead(vec, &data_));
    } else {
      petsc_check(VecGetArray(vec, &data_));
    }
  }
  VecArray(const VecArray&) = delete;
  VecArray& operator=(const VecArray&) = delete;
  ~VecArray() {
    if constexpr (read_only) {
      static_cast<void>(VecRestoreArrayRead(vec_, &data_));
    } else {
      static_cast<void>(VecRestoreArray(vec_, &data_));
    }
  }

  [[nodiscard]] T* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::span<T> span() const { return {data_, size_}; }
  T& operator[](std::size_t i) const { return data_[i]; }

 private:
  Vec vec_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace ductile::membrane
