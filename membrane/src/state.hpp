// State in both directions, for functions that name each part once: transfer(to or from, name,
// part) writes the part with a StateWriter and fills it with a StateReader.
#pragma once

#include <type_traits>

#include "ductile/membrane/integrator.hpp"

namespace ductile::membrane {

inline void transfer(const StateWriter& write, std::string_view name, const VecPtr& vec) {
  const VecArray<const double> array(vec.get());
  write(name, array.span());
}
inline void transfer(const StateReader& read, std::string_view name, const VecPtr& vec) {
  const VecArray<double> array(vec.get());
  read(name, array.span());
}

template <class Number>
requires std::is_arithmetic_v<Number>
void transfer(const StateWriter& write, std::string_view name, const Number& number) {
  const auto value = static_cast<double>(number);
  write(name, {&value, 1});
}
template <class Number>
requires std::is_arithmetic_v<Number>
void transfer(const StateReader& read, std::string_view name, Number& number) {
  double value = 0;
  read(name, {&value, 1});
  number = static_cast<Number>(value);
}

}  // namespace ductile::membrane
