// --discover: the daemons of the local network, instead of a command. Not RT.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "clients/ctl/commands.h"
#include "clients/ctl/discovery.h"
#include "clients/ctl/text.h"
#include "proto/wire/shown_text.h"

namespace hapticd::ctl {
namespace {

using Json = nlohmann::ordered_json;

void print_json(const std::vector<FoundDaemon>& found) {
  Json list = Json::array();
  for (const FoundDaemon& daemon : found) {
    list.push_back({{"name", daemon.name},
                    {"host", daemon.host},
                    {"server", server_text(daemon)},
                    {"keys", daemon.keys},
                    {"protocol", daemon.protocol}});
  }
  print_text(to_json(Json{{"daemons", list}}));
}

void print_lines(const std::vector<FoundDaemon>& found) {
  for (const FoundDaemon& daemon : found) {
    std::printf("%-32s %-28s %s\n", wire::shown_text(daemon.name).c_str(),
                wire::shown_text(server_text(daemon)).c_str(),
                daemon.keys ? "needs --key" : "no key");
  }
}

}  // namespace

void add_discover_option(CLI::App& app, const GlobalOptions& options) {
  app.add_flag_callback(
      "--discover",
      [&options] {
        const std::vector<FoundDaemon> found = discover(timeout_of(options));
        if (options.json) {
          print_json(found);
        } else {
          print_lines(found);
        }
        if (found.empty()) {
          throw Failure(kRefused,
                        "no hapticd is announced here. Start one with --announce and --keys");
        }
        // No command is wanted.
        throw CLI::Success();
      },
      "list the daemons announced on the local network by mDNS; needs avahi-daemon");
}

}  // namespace hapticd::ctl
