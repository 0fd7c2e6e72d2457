#include "ductile/membrane/petsc.hpp"

#include <string>

namespace ductile::membrane {
namespace {

std::string message(PetscErrorCode code, const char* file, int line) {
  const char* text = nullptr;
  if (PetscErrorMessage(code, &text, nullptr) != 0 || text == nullptr) text = "unknown error";
  return "PETSc error " + std::to_string(code) + " (" + text + ") at " + file + ":" +
         std::to_string(line);
}

}  // namespace

PetscFailure::PetscFailure(PetscErrorCode code, const char* file, int line)
    : std::runtime_error(message(code, file, line)), code_(code) {}

VecPtr create_vec(int vertex_count) {
  Vec vec = nullptr;
  petsc_check(VecCreate(PETSC_COMM_SELF, &vec));
  VecPtr owner(vec);
  petsc_check(VecSetSizes(vec, 3 * vertex_count, PETSC_DETERMINE));
  petsc_check(VecSetBlockSize(vec, 3));
  petsc_check(VecSetType(vec, VECSEQ));
  petsc_check(VecZeroEntries(vec));
  return owner;
}

}  // namespace ductile::membrane
