// A table of numbers on its way to CSV: rows of columns named in the first line, doubles with 17
// significant digits, so that they keep their bits. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace hapticd {

/// Adds --output to `command`; "" is stdout.
void add_output_option(CLI::App& command, std::string& output);

/// Writes `text` to the file, or to stdout for "". Throws std::runtime_error naming the file.
void write_output(const std::string& output, const std::string& text);

/// `value` so that it is read back with the same bits.
[[nodiscard]] std::string exact_text(double value);

class Table {
 public:
  /// Names with commas or quotes in them are quoted.
  explicit Table(const std::vector<std::string>& columns);

  /// Appends to the row under way.
  Table& operator<<(double value);
  Table& operator<<(std::uint64_t value);
  /// Ends it.
  void end_row();

  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  void separate();

  std::string text_;
  bool row_begun_ = false;
};

}  // namespace hapticd
