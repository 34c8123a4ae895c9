// keygen: makes the keys of a daemon, and those of single clients; lists and revokes these. It
// needs no daemon: one that runs sees the files. Not RT.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "proto/noise/client_keys.h"
#include "proto/wire/shown_text.h"

namespace hapticd::ctl {
namespace {

using Json = nlohmann::ordered_json;

struct KeygenOptions {
  std::string folder;
  std::string client;  ///< makes a key for it; empty: no
  std::string role;    ///< of that key
  std::string revoked;
  bool list = false;
};

const char* name_of(noise::Role role) { return role == noise::Role::kControl ? "control" : "view"; }

void make_all(const KeygenOptions& given, bool json) {
  noise::make_key_folder(given.folder);
  if (json) {
    const std::filesystem::path made(given.folder);
    print_text(to_json(Json{{"server_key", (made / noise::kServerKeyName).string()},
                            {"view_key", (made / noise::kViewKeyName).string()},
                            {"control_key", (made / noise::kControlKeyName).string()},
                            {"stop_key", (made / noise::kStopKeyName).string()}}));
    return;
  }
  std::printf(
      "%s: view.key may look, control.key may control, stop.key may stop; server.key is the "
      "daemon's own and stays there. Start hapticd --keys %s, and bring each client its key over a "
      "safe channel.\n",
      given.folder.c_str(), given.folder.c_str());
}

void make_client(const KeygenOptions& given, bool json) {
  const noise::Role role = given.role == "control" ? noise::Role::kControl : noise::Role::kView;
  const std::string file = noise::make_client_key(given.folder, given.client, role).string();
  if (json) {
    print_text(to_json(Json{{"client", given.client}, {"role", given.role}, {"key", file}}));
    return;
  }
  std::printf(
      "%s: the key of %s, who may %s. Bring it over a safe channel; hapticd knows it in a "
      "second.\n",
      file.c_str(), given.client.c_str(), given.role == "control" ? "control" : "look");
}

void list(const KeygenOptions& given, bool json) {
  const noise::ServerKeys keys = noise::read_key_folder(given.folder);
  const noise::ClientKeys clients = noise::read_client_keys(given.folder, keys);
  Json all = Json::array();
  for (const noise::KnownKey& key : clients.known) {
    all.push_back({{"client", key.name}, {"role", name_of(key.role)}});
    if (!json) std::printf("%-64s %s\n", key.name.c_str(), name_of(key.role));
  }
  for (const std::string& problem : clients.problems) {
    std::fprintf(stderr, "not used: %s\n", wire::shown_text(problem).c_str());
  }
  if (json) print_text(to_json(Json{{"clients", all}}));
}

void revoke(const KeygenOptions& given, bool json) {
  noise::revoke_client_key(given.folder, given.revoked);
  if (json) {
    print_text(to_json(Json{{"revoked", given.revoked}}));
    return;
  }
  std::printf("%s is revoked: hapticd ends its sessions in a second.\n", given.revoked.c_str());
}

void run(const KeygenOptions& given, bool json) {
  if (!given.client.empty()) return make_client(given, json);
  if (!given.revoked.empty()) return revoke(given, json);
  if (given.list) return list(given, json);
  make_all(given, json);
}

}  // namespace

void add_keygen_command(CLI::App& app, const GlobalOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "keygen",
      "Makes a folder with server.key, view.key, control.key and stop.key, or in it the "
      "key of one client");
  const auto given = std::make_shared<KeygenOptions>();
  command.add_option("DIR", given->folder, "folder of the keys; created if needed")->required();
  auto* client = command.add_option(
      "--client", given->client, "make a key for this client alone; small letters, digits, _, -");
  client->type_name("NAME");
  auto* role = command.add_option("--role", given->role, "what the client may do");
  role->check(CLI::IsMember({"view", "control"}))->type_name("view|control");
  role->needs(client);
  client->needs(role);
  auto* listing = command.add_flag("--list", given->list, "list the keys of clients");
  command.add_option("--revoke", given->revoked, "end the key of this client, and its sessions")
      ->type_name("NAME")
      ->excludes(client)
      ->excludes(listing);
  listing->excludes(client);
  command.callback([&options, given] {
    try {
      run(*given, options.json);
    } catch (const std::runtime_error& error) {
      throw Failure(kRefused, error.what());
    }
  });
}

}  // namespace hapticd::ctl
