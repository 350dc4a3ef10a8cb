// Issues, progress and tables; see report.hpp.
#include "report.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace shadowcut::cli {

namespace {

// The width of a text in columns: continuation bytes of UTF-8 have no width.
std::size_t columns_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void list_issues(const Scene& scene, const std::string& file, std::size_t most) {
  const auto issues = scene.issues();
  for (std::size_t i = 0; i < std::min(issues.size(), most); ++i)
    std::cerr << "shadowcut: " << io::describe(scene, issues[i], file) << '\n';
  if (issues.size() > most)
    std::cerr << "shadowcut: " << file << ": " << issues.size() - most
              << " more faces refused or repaired; 'shadowcut inspect' lists them\n";
}

Alignment alignment_of(const Scene& scene) {
  Alignment all;
  for (const Object& o : scene.objects()) {
    all.facets += o.aligned;
    all.by = std::max(all.by, o.aligned_by);
  }
  return all;
}

std::string sentence(const Alignment& alignment) {
  if (alignment.facets == 0) return {};
  return std::to_string(alignment.facets) +
         " facets put into a plane common with others, at most " + significant(alignment.by) +
         " from where they were\n";
}

std::string Table::text() const {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], columns_of(row[i]));
  std::string text;
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - columns_of(row[i]), ' ');
      text += i == 0 ? row[i] + space : "  " + space + row[i];
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  return text;
}

std::string significant(double value) { return formatted("%.6g", value); }
std::string tenths(double value) { return formatted("%.1f", value); }
std::string thousandths(double value) { return formatted("%.3f", value); }

ProgressBar::ProgressBar(bool wanted) : wanted_(wanted && ::isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (shown_ >= 0) std::cerr << "\r\033[K" << std::flush;
}

void ProgressBar::show(double share) {
  if (!wanted_ || milliseconds_since(start_) < 500) return;
  const int hundredths = std::clamp(static_cast<int>(share * 100), 0, 100);
  if (hundredths == shown_) return;
  shown_ = hundredths;
  const auto filled = static_cast<std::size_t>(hundredths * 40 / 100);
  std::cerr << "\r[" << std::string(filled, '#') << std::string(40 - filled, '.') << "] "
            << hundredths << " %" << std::flush;
}

}  // namespace shadowcut::cli
