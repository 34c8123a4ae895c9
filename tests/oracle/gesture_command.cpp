// hapticd-oracle gesture: an installed gesture as data, for programs that change it before they
// play it. Not RT.
#include <google/protobuf/text_format.h>

#include <memory>

#include "tests/oracle/commands.h"
#include "tests/oracle/gesture_path.h"
#include "tests/oracle/scene_option.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

struct GestureOptions {
  std::string gesture;
  std::string data;
  std::string output;
};

void write_gesture(const GestureOptions& options) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(load_checked_gesture(options.gesture, options.data),
                                              &text);
  write_output(options.output, text);
}

}  // namespace

void add_gesture_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("gesture", "a gesture in protobuf text format, its defaults filled in");
  const auto options = std::make_shared<GestureOptions>();
  command
      ->add_option("GESTURE", options->gesture,
                   "name of an installed gesture, or a .textproto file")
      ->required();
  add_data_option(*command, options->data);
  add_output_option(*command, options->output);
  command->callback([options] { write_gesture(*options); });
}

}  // namespace hapticd
