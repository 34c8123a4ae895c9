// The command for the experiment, which is hapticd-lab's own. Not RT.
#include <algorithm>

#include "clients/ctl/commands.h"
#include "clients/ctl/daemon_program.h"

namespace hapticd::ctl {

void add_experiment_command(CLI::App& app, const GlobalOptions& options) {
  CLI::App* experiment = app.add_subcommand(
      "experiment", "which string is stiffer? 27 trials with a person (hapticd-lab experiment)");
  // Every word is hapticd-lab's, --help too.
  experiment->prefix_command()->fallthrough(false)->set_help_flag();
  experiment->callback([&options, experiment] {
    refuse_json(options, "an experiment talks with a person; its folder has the answers");
    std::vector<std::string> words = experiment->remaining();
    const auto has = [&words](const std::string& option) {
      return std::any_of(words.begin(), words.end(), [&option](const std::string& word) {
        return word == option || word.starts_with(option + "=");
      });
    };
    // Also where one that was begun with --live is resumed.
    if (!has("--address")) words.insert(words.end(), {"--address", options.daemon.server});
    if (!options.daemon.key_file.empty() && !has("--key")) {
      words.insert(words.end(), {"--key", options.daemon.key_file});
    }
    words.insert(words.begin(), "experiment");
    become_program("hapticd-lab", words);
  });
}

}  // namespace hapticd::ctl
