// Text output for people: issues, a progress bar, and tables.
#pragma once

#include <chrono>
#include <shadowcut/io.hpp>
#include <string>
#include <vector>

namespace shadowcut::cli {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start);

// Prints one line on standard error for each issue, up to `most` issues, and one line with the
// number of further issues.
void list_issues(const Scene& scene, const std::string& file, std::size_t most);

// Facets that were snapped to a shared plane; see Scene::coplanarity_tolerance.
struct Alignment {
  std::uint64_t facets = 0;
  double by = 0;  // the largest distance by which a corner moved
};
Alignment alignment_of(const Scene& scene);
std::string sentence(const Alignment& alignment);  // one line; empty without such facets

// Columns of text, the first flush left and the others flush right.
class Table {
 public:
  explicit Table(std::vector<std::string> head) : rows_{std::move(head)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

std::string significant(double value);  // six digits
std::string tenths(double value);
std::string thousandths(double value);

// A progress bar on standard error, if that is a terminal and the work takes over half a second.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  void show(double share);

 private:
  const bool wanted_;
  const Clock::time_point start_ = Clock::now();
  int shown_ = -1;  // in hundredths
};

}  // namespace shadowcut::cli
