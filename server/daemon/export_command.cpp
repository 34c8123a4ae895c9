// See commands.h.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/hints/command_line_fault.h"
#include "proto/recording/recording_reader.h"
#include "proto/recording/recording_table.h"
#include "server/daemon/commands.h"
#include "server/daemon/daemon_options.h"

namespace hapticd {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

int run_export(int argc, const char* const* argv) {
  std::string recording;
  std::string what = "ticks";
  std::string csv;
  std::string npy;
  bool json = false;
  CLI::App app("Writes a recording as a table, one row per tick or per event.", "hapticd export");
  app.add_option("FILE", recording,
                 "recording: a file, or a name that `hapticctl record list` shows")
      ->required();
  app.add_option("--what", what, "ticks or events (ticks)")
      ->check(CLI::IsMember({"ticks", "events"}))
      ->type_name("ticks|events");
  auto* group = app.add_option_group("output");
  group->add_option("--csv", csv, "file to write, as text")->type_name("OUT");
  group->add_option("--npy", npy, "file to write, for numpy.load")->type_name("OUT");
  group->require_option(1);
  app.add_flag("--json", json, "what was written as one JSON object, for programs");
  app.failure_message(hints::failure_message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitGood : kExitUsage;
  }
  const std::string& out = csv.empty() ? npy : csv;
  try {
    const std::uint64_t rows =
        write_table(recording, what == "ticks" ? TableRows::kTicks : TableRows::kEvents,
                    csv.empty() ? TableForm::kNpy : TableForm::kCsv, out);
    if (json) {
      const Json written = {{"rows", rows}, {"what", what}, {"file", out}};
      std::printf("%s\n", written.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
      return kExitGood;
    }
    std::printf("%llu %s in %s\n", static_cast<unsigned long long>(rows), what.c_str(),
                out.c_str());
  } catch (const RecordingError& error) {
    std::fprintf(stderr, "hapticd: %s\n", error.what());
    return kExitInput;
  }
  return kExitGood;
}

}  // namespace hapticd
