// See commands.h.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <vector>

#include "device/attach/device_list.h"
#include "device/report_io/hidraw_nodes.h"
#include "proto/hints/command_line_fault.h"
#include "server/daemon/commands.h"
#include "server/daemon/daemon_options.h"

namespace hapticd {

int run_device(int argc, const char* const* argv) {
  bool json = false;
  CLI::App app("Devices of this machine.", "hapticd device");
  CLI::App* list = app.add_subcommand("list", "what is plugged in that hapticd can drive");
  list->add_flag("--json", json, "as JSON, for programs");
  app.require_subcommand(1);
  app.failure_message(hints::failure_message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kListGood : kExitUsage;
  }
  const std::vector<ListedDevice> devices = drivable(list_hidraw_nodes());
  std::fputs((json ? list_json(devices) : list_text(devices)).c_str(), stdout);
  return list_exit_code(devices);
}

}  // namespace hapticd
