#include "output/checksum.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <new>

namespace ductile::drivers {

struct Checksum::State {
  State() : xxh(XXH3_createState()) {
    if (xxh == nullptr) throw std::bad_alloc();
    XXH3_64bits_reset(xxh);
  }
  ~State() { XXH3_freeState(xxh); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  XXH3_state_t* xxh;
};

Checksum::Checksum() : state_(std::make_unique<State>()) {}
Checksum::~Checksum() = default;

void Checksum::add(const void* data, std::size_t size) {
  XXH3_64bits_update(state_->xxh, data, size);
}

std::uint64_t Checksum::value() const {
  return XXH3_64bits_digest(state_->xxh);
}

std::string Checksum::text() const {
  return fmt::format("{:016x}", value());
}

}  // namespace ductile::drivers
