// See table.h.
#include "tests/oracle/table.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace hapticd {
namespace {

/// Why the last call to the system failed.
std::string why() { return std::generic_category().message(errno); }

std::string quoted(const std::string& name) {
  if (name.find_first_of(",\"\n") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

}  // namespace

void add_output_option(CLI::App& command, std::string& output) {
  command.add_option("--output,-o", output, "file to write (default: stdout)")->type_name("FILE");
}

void write_output(const std::string& output, const std::string& text) {
  if (output.empty()) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
        std::fflush(stdout) == 0) {
      return;
    }
    throw std::runtime_error("stdout cannot be written: " + std::string(why()) +
                             ". Name a file with --output");
  }
  std::ofstream file(output, std::ios::binary);
  file << text << std::flush;
  if (!file) {
    throw std::runtime_error(output + ": cannot be written: " + why() +
                             ". Name another file with --output");
  }
}

std::string exact_text(double value) {
  std::array<char, 32> digits{};
  const int length = std::snprintf(digits.data(), digits.size(), "%.17g", value);
  return {digits.data(), static_cast<std::size_t>(length)};
}

Table::Table(const std::vector<std::string>& columns) {
  for (const std::string& column : columns) {
    separate();
    text_ += quoted(column);
  }
  end_row();
}

void Table::separate() {
  if (row_begun_) text_ += ',';
  row_begun_ = true;
}

Table& Table::operator<<(double value) {
  separate();
  text_ += exact_text(value);
  return *this;
}

Table& Table::operator<<(std::uint64_t value) {
  separate();
  text_ += std::to_string(value);
  return *this;
}

void Table::end_row() {
  text_ += '\n';
  row_begun_ = false;
}

}  // namespace hapticd
