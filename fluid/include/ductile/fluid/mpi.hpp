// MPI with every code checked.
#pragma once

#include <mpi.h>

#include <stdexcept>

namespace ductile::fluid {

/// A call of MPI failed: its name, and what MPI says of the error.
class MpiFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws MpiFailure naming `call` unless `code`, which it has returned, is MPI_SUCCESS. MPI
/// returns other codes only on communicators with MPI_ERRORS_RETURN, such as a Communicator's.
void mpi_check(int code, const char* call);

/// A duplicate of a communicator, with a context of its own for messages, on which MPI returns
/// errors instead of ending the program. Owns the duplicate.
class Communicator {
 public:
  /// Collective over `comm`. Throws MpiFailure.
  explicit Communicator(MPI_Comm comm);
  /// Collective.
  ~Communicator();
  Communicator(Communicator&& other) noexcept;
  Communicator& operator=(Communicator&& other) noexcept;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] MPI_Comm get() const { return comm_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace ductile::fluid
