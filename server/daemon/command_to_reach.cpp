// See command_to_reach.h.
#include "server/daemon/command_to_reach.h"

#include <filesystem>
#include <string_view>
#include <utility>

#include "proto/hints/shell_word.h"

namespace hapticd {
namespace {

/// Where hapticctl looks that is told nothing else.
constexpr std::string_view kLookedAt = "127.0.0.1:47800";

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
    command += "--key " + hints::shell_word(key.lexically_normal().string()) + " ";
  }
  return command + "status";
}

}  // namespace hapticd
