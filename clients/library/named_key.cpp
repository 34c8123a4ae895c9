// See named_key.h.
#include "clients/library/named_key.h"

#include <stdexcept>

namespace hapticd::client {
namespace {

std::optional<wire::Role> role_of(const std::string& role) {
  if (role.empty()) return std::nullopt;
  if (role == "view") return wire::Role::kView;
  if (role == "control") return wire::Role::kControl;
  throw std::invalid_argument("there is no role " + role + ": give view or control");
}

}  // namespace

std::optional<ClientKey> named_key(const std::string& file, const std::string& role) {
  if (file.empty()) return std::nullopt;
  return read_client_key(file, role_of(role));
}

}  // namespace hapticd::client
