// See key_folder.h.
#include "proto/noise/key_folder.h"

#include <optional>
#include <system_error>

#include "proto/noise/private_file.h"

namespace hapticd::noise {
namespace {

namespace fs = std::filesystem;

struct RoleFile {
  const char* name;
  Role role;
};
constexpr RoleFile kRoleFiles[] = {{kViewKeyName, Role::kView}, {kControlKeyName, Role::kControl}};

bool is_there(const fs::path& file) {
  std::error_code unknown;
  return fs::exists(fs::symlink_status(file, unknown));
}

bool is_of_before(const fs::path& file) {
  std::error_code unknown;
  return fs::file_size(file, unknown) == kBareKeyBytes;
}

KnownKey read_known(const fs::path& file, const std::string& name, const Key& server) {
  const SessionKey key = read_session_key(file);
  if (key.server != server) {
    refuse_file(file,
                "a key of another daemon: its server key is not that of server.key. Make keys "
                "with 'hapticctl keygen DIR' in a new folder.");
  }
  return {name, key.role, key.psk};
}

// What clients of before have still opens; they are told what to do.
void complete(const fs::path& folder) {
  const bool has_own = is_there(folder / kServerKeyName);
  for (const RoleFile& file : kRoleFiles) {
    if (!has_own && !is_of_before(folder / file.name)) {
      refuse_file(folder / kServerKeyName,
                  "is gone, and view.key and control.key are of no use without it. Remove them, "
                  "and make new ones.");
    }
  }
  if (!has_own) write_bare_key(folder / kServerKeyName, random_key());
  const Key server = public_half(read_bare_key(folder / kServerKeyName).get());
  for (const RoleFile& file : kRoleFiles) {
    if (!is_of_before(folder / file.name)) continue;
    replace_session_key(folder / file.name, {file.role, read_bare_key(folder / file.name), server});
  }
  if (!is_there(folder / kStopKeyName)) write_bare_key(folder / kStopKeyName, random_key());
}

void make_all(const fs::path& folder) {
  const SecretKey own = random_key();
  write_bare_key(folder / kServerKeyName, own);
  for (const RoleFile& file : kRoleFiles) {
    write_session_key(folder / file.name, {file.role, random_key(), public_half(own.get())});
  }
  write_bare_key(folder / kStopKeyName, random_key());
}

}  // namespace

ServerKeys server_keys(const SecretKey& own, const SecretKey& view, const SecretKey& control) {
  return {own, public_half(own.get()), {{"", Role::kView, view}, {"", Role::kControl, control}}};
}

ServerKeys read_key_folder(const fs::path& folder) {
  ServerKeys keys;
  if (!is_there(folder / kServerKeyName) && is_of_before(folder / kViewKeyName)) {
    refuse_file(folder,
                "keys of an earlier version, by which clients cannot tell this daemon from "
                "another. Run 'hapticctl keygen DIR' on it, which keeps them and adds what is "
                "missing, and bring each client its new file.");
  }
  // Named first where all are missing: it is what people know.
  if (!is_there(folder / kViewKeyName)) (void)read_session_key(folder / kViewKeyName);
  keys.own = read_bare_key(folder / kServerKeyName);
  keys.server = public_half(keys.own.get());
  for (const RoleFile& file : kRoleFiles) {
    keys.known.push_back(read_known(folder / file.name, "", keys.server));
    if (keys.known.back().role != file.role) {
      refuse_file(folder / file.name, "the key of another role. Copy the right one back.");
    }
  }
  if (keys.known[0].psk == keys.known[1].psk) {
    refuse_file(folder,
                "view.key and control.key are equal, so that who may look could control. Make "
                "keys with 'hapticctl keygen DIR'.");
  }
  return keys;
}

void make_key_folder(const fs::path& named) {
  // keys/ is keys: what follows the last slash is not a separate folder.
  const fs::path folder = named.has_filename() ? named : named.parent_path();
  make_private_folder(folder);
  const bool both = is_there(folder / kViewKeyName) && is_there(folder / kControlKeyName);
  const bool whole = is_there(folder / kServerKeyName) && is_there(folder / kStopKeyName) &&
                     !is_of_before(folder / kViewKeyName) &&
                     !is_of_before(folder / kControlKeyName);
  if (both && !whole) {
    complete(folder);
    return;
  }
  for (const char* name : {kViewKeyName, kControlKeyName, kStopKeyName, kServerKeyName}) {
    if (is_there(folder / name)) {
      refuse_file(folder / name,
                  "exists already, and clients may have it. Remove all keys first, or give another "
                  "folder.");
    }
  }
  make_all(folder);
}

}  // namespace hapticd::noise
