// What a person types behind an option that asks for a number. For tests.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <string>

namespace hapticd::hints::test {

/// Parses `--number text`; why it is refused, empty where it is not.
inline std::string fault_of_typed(CLI::App& app, const std::string& text) {
  const std::array words{"program", "--number", text.c_str()};
  try {
    app.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return {};
}

}  // namespace hapticd::hints::test
