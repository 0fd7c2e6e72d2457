#include "ductile/membrane/petsc.hpp"

#include <string>
#include <utility>

namespace ductile::membrane {
namespace {

// What PETSc said where the latest error arose, until somebody asks.
std::string& said() {
  static std::string text;
  return text;
}

PetscErrorCode keep_message(MPI_Comm /*comm*/, int /*line*/, const char* /*function*/,
                            const char* /*file*/, PetscErrorCode code, PetscErrorType type,
                            const char* message, void* /*context*/) {
  if (type == PETSC_ERROR_INITIAL) said() = message != nullptr ? message : "";
  return code;
}

std::string message(PetscErrorCode code, const char* file, int line) {
  std::string detail = std::exchange(said(), "");
  for (char& c : detail) c = c == '\n' ? ' ' : c;
  if (!detail.empty()) return "PETSc: " + detail;
  const char* text = nullptr;
  if (PetscErrorMessage(code, &text, nullptr) != 0 || text == nullptr) text = "unknown error";
  return "PETSc error " + std::to_string(code) + " (" + text + ") at " + file + ":" +
         std::to_string(line);
}

}  // namespace

void quieten_petsc() {
  petsc_check(PetscPushErrorHandler(keep_message, nullptr));
}

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
