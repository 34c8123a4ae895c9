// Commands that are printed for people to type. Not RT.
#pragma once

#include <algorithm>
#include <string>

namespace hapticd::hints {

/// `text` as one word for a POSIX shell: in quotes where it has more than plain characters.
[[nodiscard]] inline std::string shell_word(const std::string& text) {
  const auto is_plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '/' ||
           c == '.' || c == '_' || c == '-' || c == ':';
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

}  // namespace hapticd::hints
