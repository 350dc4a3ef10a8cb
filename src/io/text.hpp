// Words and numbers of text files, read and written without a locale and without a limit on their
// length.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace shadowcut::io {

// Cuts off and returns the first line of `rest`, without its end (\n, \r\n or \r).
std::string_view take_line(std::string_view& rest);

// Cuts off and returns the first word of `rest`: what stands between blanks. Empty when there is
// none left.
std::string_view take_word(std::string_view& rest);

// `text` without the blanks at either end.
std::string_view trimmed(std::string_view text);

// The double nearest to the decimal number that `word` is as a whole; NaN when it is none. Out of
// range: infinite, or zero.
double number_of(std::string_view word);

// Nothing when `word` as a whole is not an integer or does not fit.
std::optional<std::int64_t> integer_of(std::string_view word);

// Appends the shortest decimal that reads back as the same double.
void append(std::string& text, double value);
void append(std::string& text, std::uint64_t value);

// Valid UTF-8 without control characters: other bytes become '?'. Names go through this before they
// are written.
std::string printable(std::string_view name);

}  // namespace shadowcut::io
