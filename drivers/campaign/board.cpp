#include "campaign/board.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "output/say.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

constexpr double longest_interval = 300;  // s

std::string row_text(const BoardRow& row, std::size_t name_width) {
  const std::string time =
      row.time ? fmt::format("{:.2f} of {:g}", *row.time, row.time_limit) : "starts";
  return fmt::format("{:<{}}  {:>14}  {:>7}  {:<10} {:>10}", shortened(row.name, name_width),
                     name_width, time, row.dz ? fmt::format("{:.3f}", *row.dz) : "", row.verdict,
                     row.left ? duration_text(*row.left) : "");
}

}  // namespace

std::string counts_text(const BoardCounts& counts, std::size_t under_way) {
  std::string text = fmt::format("{} of {} cases have ended, {} under way, {} waiting",
                                 counts.ended, counts.all, under_way, counts.waiting);
  if (counts.left) text += fmt::format("; about {} left", duration_text(*counts.left));
  return text;
}

void Board::show(double now, const std::vector<BoardRow>& rows, const BoardCounts& counts) {
  const std::string summary = counts_text(counts, rows.size());
  if (!terminal_) {
    if (!next_) next_ = now + interval_;
    if (now < *next_) return;
    interval_ = std::min(2 * interval_, longest_interval);
    next_ = now + interval_;
    say(out_, "{}\n", summary);
    return;
  }
  clear();
  std::size_t name_width = 4;
  for (const BoardRow& row : rows) name_width = std::max(name_width, row.name.size());
  constexpr std::size_t others = 48;
  name_width = std::min(name_width, std::max<std::size_t>(12, width_ - std::min(width_, others)));
  std::string text = fmt::format("{:<{}}  {:>14}  {:>7}  {:<10} {:>10}\n", "case", name_width, "t",
                                 "dz", "so far", "left");
  for (const BoardRow& row : rows) text += row_text(row, name_width) + '\n';
  text += summary + '\n';
  shown_ = rows.size() + 2;
  // Not for the log, which would grow with each showing.
  std::fputs(text.c_str(), out_);
  std::fflush(out_);
}

void Board::tell(const std::string& line) {
  clear();
  say(out_, "{}\n", line);
}

void Board::finish() {
  clear();
}

// Up to the first of the lines, and everything from there on.
void Board::clear() {
  if (shown_ == 0) return;
  std::fputs(fmt::format("\x1b[{}A\x1b[J", shown_).c_str(), out_);
  std::fflush(out_);
  shown_ = 0;
}

}  // namespace ductile::drivers
