// Test main for libraries that use PETSc (which brings MPI up and down itself).
#include <gtest/gtest.h>
#include <petscsys.h>

#include <cstdlib>

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  // What the user has set for programs of his own is not the tests'.
  unsetenv("PETSC_OPTIONS");
  if (PetscOptionsSetValue(nullptr, "-skip_petscrc", nullptr) != 0) return 1;
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
  if (rank != 0) delete listeners.Release(listeners.default_result_printer());
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  if (PetscFinalize() != 0) return 1;
  return failed;
}
