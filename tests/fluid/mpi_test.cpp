#include "ductile/fluid/mpi.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace {

using namespace ductile::fluid;

std::string failure_of(MPI_Comm comm, int to) {
  const int number = 1;
  try {
    mpi_check(MPI_Send(&number, 1, MPI_INT, to, 0, comm), "MPI_Send");
  } catch (const MpiFailure& failure) {
    return failure.what();
  }
  return "";
}

TEST(Mpi, AWrongCallThrowsWithItsNameAndMpisReason) {
  const Communicator comm(MPI_COMM_WORLD);
  const std::string what = failure_of(comm.get(), comm.size() + 99);
  EXPECT_NE(what.find("MPI_Send"), std::string::npos) << what;
  EXPECT_NE(what.find("rank"), std::string::npos) << what;
  EXPECT_EQ(failure_of(comm.get(), MPI_PROC_NULL), "");
}

TEST(Mpi, ACommunicatorHasTheSameRanksAndAContextOfItsOwn) {
  Communicator comm(MPI_COMM_WORLD);
  int relation = MPI_UNEQUAL;
  mpi_check(MPI_Comm_compare(MPI_COMM_WORLD, comm.get(), &relation), "MPI_Comm_compare");
  EXPECT_EQ(relation, MPI_CONGRUENT);
  const MPI_Comm handle = comm.get();
  const Communicator moved = std::move(comm);
  EXPECT_EQ(moved.get(), handle);
  int sum = 1;
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_INT, MPI_SUM, moved.get()), "MPI_Allreduce");
  EXPECT_EQ(sum, moved.size());
  EXPECT_LT(moved.rank(), moved.size());
}

}  // namespace
