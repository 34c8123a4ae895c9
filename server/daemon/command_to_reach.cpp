// See command_to_reach.h.
#include "server/daemon/command_to_reach.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <utility>

namespace hapticd {
namespace {

/// Where hapticctl looks that is told nothing else.
constexpr std::string_view kLookedAt = "127.0.0.1:47800";

/// A word for a shell.
std::string shell_word(const std::string& text) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '/' || c == '.' || c == '_' || c == '-';
  };
  if (std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

/// Where all addresses are listened on, one that is this machine's own.
std::string own_address(const std::string& address) {
  for (const auto& [all, own] :
       {std::pair<std::string_view, std::string_view>("0.0.0.0:", "127.0.0.1:"),
        {"[::]:", "[::1]:"}}) {
    if (address.starts_with(all)) return std::string(own) + address.substr(all.size());
  }
  return address;
}

}  // namespace

std::string command_to_reach(const std::string& address, const std::string& keys) {
  const std::string server = own_address(address);
  std::string command = "hapticctl ";
  if (server != kLookedAt) command += "--server " + server + " ";
  if (!keys.empty()) {
    const auto key = std::filesystem::absolute(std::filesystem::path(keys) / "control.key");
    command += "--key " + shell_word(key.lexically_normal().string()) + " ";
  }
  return command + "status";
}

}  // namespace hapticd
