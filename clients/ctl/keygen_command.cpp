// keygen: makes the keys of a daemon, without a daemon. Not RT.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "proto/noise/key_folder.h"

namespace hapticd::ctl {

void add_keygen_command(CLI::App& app, const GlobalOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "keygen", "Makes a folder with server.key, view.key, control.key and stop.key");
  const auto folder = std::make_shared<std::string>();
  command.add_option("DIR", *folder, "folder of the keys; created if needed")->required();
  command.callback([&options, folder] {
    try {
      noise::make_key_folder(*folder);
    } catch (const std::runtime_error& error) {
      throw Failure(kRefused, error.what());
    }
    if (options.json) {
      const std::filesystem::path made(*folder);
      const nlohmann::ordered_json json = {
          {"server_key", (made / noise::kServerKeyName).string()},
          {"view_key", (made / noise::kViewKeyName).string()},
          {"control_key", (made / noise::kControlKeyName).string()},
          {"stop_key", (made / noise::kStopKeyName).string()}};
      print_text(to_json(json));
      return;
    }
    std::printf(
        "%s: view.key may look, control.key may control, stop.key may stop; server.key is the "
        "daemon's own and stays there. Start hapticd --keys %s, and bring each client its key over "
        "a "
        "safe channel.\n",
        folder->c_str(), folder->c_str());
  });
}

}  // namespace hapticd::ctl
