// Commands for recordings: played again and compared, or written as a table. Both are hapticd's
// own. Not RT.
#include <memory>

#include "clients/ctl/commands.h"
#include "clients/ctl/daemon_program.h"

namespace hapticd::ctl {
namespace {

struct ReplayOptions {
  std::string file;
  std::string listen = "127.0.0.1:0";
  bool verify = false;
  bool paced = false;
};

struct ExportOptions {
  std::string file;
  std::string csv;
  std::string npy;
  std::string what = "ticks";
};

}  // namespace

void add_replay_commands(CLI::App& app, const GlobalOptions& options) {
  CLI::App* replay = app.add_subcommand("replay",
                                        "plays a recording again (hapticd --device replay:FILE); "
                                        "exit code 5 if it differs, 8 if only "
                                        "its poses could be compared");
  const auto played = std::make_shared<ReplayOptions>();
  replay->add_option("FILE", played->file, "recording")->required();
  replay->add_flag("--verify", played->verify, "compare every wrench with the recorded one");
  replay->add_flag("--paced", played->paced,
                   "at the speed of the recording, not as fast as possible");
  replay->add_option("--listen", played->listen, "where clients may watch (any free port)")
      ->type_name("ADDR:PORT");
  replay->callback([&options, played] {
    refuse_json(options, "the exit code of a replay says how it ended");
    std::vector<std::string> arguments{"--device", "replay:" + played->file,
                                       "--clock",  played->paced ? "realtime" : "virtual",
                                       "--listen", played->listen};
    if (played->verify) arguments.emplace_back("--verify");
    become_hapticd(arguments);
  });

  CLI::App* table = app.add_subcommand("export", "writes a recording as a table (hapticd export)");
  const auto asked = std::make_shared<ExportOptions>();
  table->add_option("FILE", asked->file, "recording")->required();
  auto* csv = table->add_option("--csv", asked->csv, "file to write, as text")->type_name("OUT");
  table->add_option("--npy", asked->npy, "file to write, for numpy.load")
      ->type_name("OUT")
      ->excludes(csv);
  table->add_option("--what", asked->what, "ticks or events (ticks)")
      ->check(CLI::IsMember({"ticks", "events"}))
      ->type_name("ticks|events");
  table->callback([&options, asked] {
    std::vector<std::string> arguments{"export", asked->file, "--what", asked->what};
    if (!asked->csv.empty()) arguments.insert(arguments.end(), {"--csv", asked->csv});
    if (!asked->npy.empty()) arguments.insert(arguments.end(), {"--npy", asked->npy});
    if (options.json) arguments.emplace_back("--json");
    become_hapticd(arguments);
  });
}

}  // namespace hapticd::ctl
