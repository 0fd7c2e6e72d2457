// Saved states: all of a suspension passes through rank 0, a part at a time.
#include <algorithm>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ductile/fluid/mpi.hpp"
#include "ductile/suspension/suspension.hpp"
#include "films.hpp"
#include "planes.hpp"

namespace ductile::suspension {
namespace {

using fluid::mpi_check;

struct Elsewhere : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The first failure of a rank; work after it goes on as far as other ranks wait for it.
class Failure {
 public:
  void guard(const std::function<void()>& work) {
    try {
      work();
    } catch (const std::exception& error) {
      if (first_ && !elsewhere_) return;
      first_ = std::current_exception();
      elsewhere_ = dynamic_cast<const Elsewhere*>(&error) != nullptr;
      text_ = error.what();
    }
  }
  [[nodiscard]] bool any() const { return first_ != nullptr; }

  /// Throws on all ranks if any has failed: where it has, what it was, elsewhere its text.
  /// Collective.
  void settle(MPI_Comm comm) const {
    int rank = 0;
    int size = 0;
    mpi_check(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
    mpi_check(MPI_Comm_size(comm, &size), "MPI_Comm_size");
    int first = first_ && !elsewhere_ ? rank : size;
    mpi_check(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm), "MPI_Allreduce");
    if (first == size) return;
    std::string text = rank == first ? text_ : "";
    int length = static_cast<int>(text.size());
    mpi_check(MPI_Bcast(&length, 1, MPI_INT, first, comm), "MPI_Bcast");
    text.resize(static_cast<std::size_t>(length));
    mpi_check(MPI_Bcast(text.data(), length, MPI_CHAR, first, comm), "MPI_Bcast");
    if (first_ && !elsewhere_) std::rethrow_exception(first_);
    throw std::runtime_error(text);
  }

 private:
  std::exception_ptr first_;
  bool elsewhere_ = false;  // it is another rank's failure that this one has met
  std::string text_;
};

// What ranks tell each other of a part, ahead of its numbers. A name of no length ends a body.
struct Header {
  int name = 0;
  int numbers = 0;
  int failed = 0;
};

// Messages between an owner and rank 0, in either direction.
class Line {
 public:
  Line(MPI_Comm comm, int other) : comm_(comm), other_(other) {}

  void send(const Header& header, std::string_view name = {},
            std::span<const double> numbers = {}) const {
    mpi_check(MPI_Send(&header, 3, MPI_INT, other_, 0, comm_), "MPI_Send");
    if (!name.empty())
      mpi_check(MPI_Send(name.data(), header.name, MPI_CHAR, other_, 0, comm_), "MPI_Send");
    if (!numbers.empty()) send(numbers);
  }
  void send(std::span<const double> numbers) const {
    mpi_check(
        MPI_Send(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, other_, 0, comm_),
        "MPI_Send");
  }
  [[nodiscard]] Header header() const {
    Header header;
    mpi_check(MPI_Recv(&header, 3, MPI_INT, other_, 0, comm_, MPI_STATUS_IGNORE), "MPI_Recv");
    return header;
  }
  [[nodiscard]] std::string name(const Header& header) const {
    std::string name(static_cast<std::size_t>(header.name), ' ');
    mpi_check(MPI_Recv(name.data(), header.name, MPI_CHAR, other_, 0, comm_, MPI_STATUS_IGNORE),
              "MPI_Recv");
    return name;
  }
  void receive(std::span<double> numbers) const {
    if (numbers.empty()) return;
    mpi_check(MPI_Recv(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, other_, 0,
                       comm_, MPI_STATUS_IGNORE),
              "MPI_Recv");
  }

 private:
  MPI_Comm comm_;
  int other_;
};

Header header_of(std::string_view name, std::size_t numbers) {
  return {static_cast<int>(name.size()), static_cast<int>(numbers), 0};
}

}  // namespace

void Suspension::save(const StateWriter& write) {
  const Planes planes(fluid_, comm());
  const bool root = rank() == 0;
  Failure failure;
  const auto put = [&](const std::string& name, std::span<const double> numbers) {
    if (!failure.any()) failure.guard([&] { write(name, numbers); });
  };
  fluid_.save([&](std::string_view name, std::span<const double> numbers) {
    const std::string path = "fluid/" + std::string(name);
    if (numbers.size() != planes.own_size()) {  // the same on every rank
      if (root) put(path, numbers);
      return;
    }
    const std::vector<double> whole = planes.gathered(numbers);
    if (root) put(path, whole);
  });
  if (films_ && root) {  // the same on every rank
    films_->lubrication().save([&](std::string_view name, std::span<const double> numbers) {
      put("films/" + std::string(name), numbers);
    });
  }
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const std::string prefix = "body/" + plan_.bodies[b].name + "/";
    if (root && owner(b) == 0) {
      failure.guard([&] {
        own(b)->save([&](std::string_view name, std::span<const double> numbers) {
          put(prefix + std::string(name), numbers);
        });
      });
    } else if (rank() == owner(b)) {
      const Line line(comm(), 0);
      failure.guard([&] {
        own(b)->save([&](std::string_view name, std::span<const double> numbers) {
          line.send(header_of(name, numbers.size()), name, numbers);
        });
      });
      line.send(Header{});
    } else if (root) {
      const Line line(comm(), owner(b));
      std::vector<double> numbers;
      for (Header header = line.header(); header.name > 0; header = line.header()) {
        const std::string name = line.name(header);
        numbers.resize(static_cast<std::size_t>(header.numbers));
        line.receive(numbers);
        put(prefix + name, numbers);
      }
    }
  }
  failure.settle(comm());
}

void Suspension::load(const StateReader& read) {
  const Planes planes(fluid_, comm());
  const bool root = rank() == 0;
  Failure failure;
  // Rank 0's alone may fail; then all stop at the same part.
  const auto shared = [&](const std::string& path, bool of_nodes, std::span<double> numbers) {
    std::vector<double> whole(root ? (of_nodes ? planes.whole_size() : numbers.size()) : 0);
    std::exception_ptr refused;
    if (root) {
      try {
        read(path, whole);
      } catch (...) {
        refused = std::current_exception();
      }
    }
    int failed = refused ? 1 : 0;
    mpi_check(MPI_Bcast(&failed, 1, MPI_INT, 0, comm()), "MPI_Bcast");
    if (refused) std::rethrow_exception(refused);
    if (failed != 0) throw Elsewhere("the state could not be loaded on another rank");
    if (of_nodes) {
      planes.scatter(whole, numbers);
      return;
    }
    std::ranges::copy(whole, numbers.begin());
    mpi_check(MPI_Bcast(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, 0, comm()),
              "MPI_Bcast");
  };
  failure.guard([&] {
    fluid_.load([&](std::string_view name, std::span<double> numbers) {
      shared("fluid/" + std::string(name), numbers.size() == planes.own_size(), numbers);
    });
    if (!films_) return;
    films_->lubrication().load([&](std::string_view name, std::span<double> numbers) {
      shared("films/" + std::string(name), false, numbers);
    });
  });

  for (const Owned& owned : root ? std::span<const Owned>(bodies_) : std::span<const Owned>()) {
    const std::string prefix = "body/" + plan_.bodies[owned.index].name + "/";
    failure.guard([&] {
      owned.body->load([&](std::string_view name, std::span<double> numbers) {
        read(prefix + std::string(name), numbers);
      });
    });
  }
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    if (owner(b) == 0) continue;
    if (root) {
      const Line line(comm(), owner(b));
      const std::string prefix = "body/" + plan_.bodies[b].name + "/";
      std::vector<double> numbers;
      for (Header header = line.header(); header.name > 0; header = line.header()) {
        const std::string name = prefix + line.name(header);
        numbers.resize(static_cast<std::size_t>(header.numbers));
        Header answer;
        try {
          read(name, numbers);
        } catch (...) {
          failure.guard([] { throw; });
          answer.failed = 1;
        }
        line.send(answer);
        if (answer.failed == 0 && !numbers.empty()) line.send(numbers);
      }
    } else if (rank() == owner(b)) {
      const Line line(comm(), 0);
      const auto body = std::ranges::find(bodies_, b, &Owned::index);
      failure.guard([&] {
        body->body->load([&](std::string_view name, std::span<double> numbers) {
          line.send(header_of(name, numbers.size()), name);
          if (line.header().failed != 0)
            throw Elsewhere("the state could not be loaded on another rank");
          line.receive(numbers);
        });
      });
      line.send(Header{});
    }
  }
  coupler_->bodies_replaced();
  failure.settle(comm());
}

}  // namespace ductile::suspension
