#include "campaign/watch.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

namespace ductile::drivers {
namespace {

std::vector<std::string_view> cells(std::string_view line) {
  std::vector<std::string_view> list;
  for (;;) {
    const std::size_t comma = line.find(',');
    list.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return list;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

void RunWatch::look() {
  std::ifstream in(file_, std::ios::binary);
  if (!in || !in.seekg(static_cast<std::streamoff>(read_))) return;
  // A line that is not whole is left for the next time.
  for (std::string line; std::getline(in, line) && !in.eof();) {
    read_ += line.size() + 1;
    header_ ? take_row(line) : take_header(line);
  }
}

void RunWatch::take_header(const std::string& line) {
  header_ = true;
  const std::vector<std::string_view> names = cells(line);
  for (std::size_t n = 0; n < names.size(); ++n) {
    if (names[n] == "dz[W]") dz_column_ = n;
    if (!names[n].ends_with("_x[W]")) continue;
    if (!lead_) {
      lead_ = n;
    } else if (!lag_) {
      lag_ = n;
    }
  }
}

void RunWatch::take_row(const std::string& line) {
  std::vector<double> numbers;
  for (const std::string_view cell : cells(line)) {
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return;
    numbers.push_back(value);
  }
  const double time = numbers[0];
  if (time_ && !(time > *time_)) return;
  time_ = time;
  if (!dz_column_ || !lead_ || !lag_ || numbers.size() <= std::max(*dz_column_, *lag_)) return;
  dz_ = numbers[*dz_column_];
  judge_.update(time, *dz_, numbers[*lead_], numbers[*lag_]);
}

}  // namespace ductile::drivers
