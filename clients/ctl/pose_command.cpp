// pose: a table of poses becomes the motion of the scripted device, a row a tick. Under the virtual
// clock the ticks are run as the poses come; under the real clock rows are sent as fast as ticks
// pass. Not RT.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"

namespace hapticd::ctl {
namespace {

/// Ticks run at once under the virtual clock.
constexpr std::uint64_t kTicksPerRun = 140;
/// Rows sent ahead of the real clock, s: a hiccup of the network shorter than this is not felt.
constexpr double kAhead = 0.1;

struct PoseOptions {
  std::string file = "-";
  std::uint32_t tool = 0;
};

/// What became of the rows.
struct Streamed {
  std::uint64_t rows = 0;
  std::uint64_t refused = 0;
  std::uint64_t held = 0;
  std::string first_refusal;
};

/// The next pose of `input`; nothing at its end.
std::optional<v1::Pose> next_pose(std::istream& input, int& line_number) {
  std::string line;
  while (std::getline(input, line)) {
    auto pose = parse_pose(line, ++line_number);
    if (pose) return pose;
  }
  return std::nullopt;
}

void run_ticks(client::Controller& controller, std::uint64_t ticks, const GlobalOptions& options,
               Streamed& streamed) {
  if (ticks == 0) return;
  const v1::Result result = controller.run(ticks, timeout_of(options));
  require(result);
  streamed.held += result.run().held_inputs();
}

void stream(std::istream& input, const PoseOptions& choice, const GlobalOptions& options,
            client::Client& client, Streamed& streamed) {
  client::Controller controller(client);
  acquire(controller, client, options);
  const bool lockstep = client.scene()->clock() == v1::CLOCK_MODE_VIRTUAL;
  const double rate = client.scene()->rate_hz() > 0.0 ? client.scene()->rate_hz() : 1000.0;
  const std::int64_t began_ns = client::monotonic_now_ns();
  int line_number = 0;
  std::uint64_t unrun = 0;
  while (const auto pose = next_pose(input, line_number)) {
    controller.pose(choice.tool, *pose);
    ++streamed.rows;
    if (lockstep && ++unrun == kTicksPerRun) {
      run_ticks(controller, unrun, options, streamed);
      unrun = 0;
    }
    const double due = static_cast<double>(streamed.rows) / rate - kAhead;
    const auto late = [&] {
      return static_cast<double>(client::monotonic_now_ns() - began_ns) * 1e-9 >= due;
    };
    if (!lockstep) client.poll_until(late, std::chrono::seconds(1));
  }
  if (lockstep) run_ticks(controller, unrun, options, streamed);
  // Whatever is still to be sent goes before this.
  v1::Item ping;
  ping.mutable_ping();
  require(controller.call(ping, timeout_of(options)));
  controller.release();
}

void pose(const GlobalOptions& options, const PoseOptions& choice) {
  auto streamed = std::make_shared<Streamed>();
  client::ClientHandlers handlers;
  handlers.pose_refused = [streamed](const v1::Result& result) {
    if (streamed->refused++ > 0) return;
    streamed->first_refusal = plain_name(v1::ResultCode_Name(result.code()), "RESULT_CODE_") +
                              (result.message().empty() ? "" : ": " + result.message());
  };
  std::ifstream file;
  if (choice.file != "-") file.open(choice.file);
  if (choice.file != "-" && !file) throw Failure(kRefused, choice.file + ": cannot be read");
  const auto client = connect(options, handlers);
  stream(choice.file == "-" ? std::cin : file, choice, options, *client, *streamed);
  const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  if (options.json) {
    const nlohmann::ordered_json json = {{"rows", streamed->rows},
                                         {"refused_batches", streamed->refused},
                                         {"held_inputs", streamed->held}};
    print_text(to_json(json));
  } else {
    std::printf("%llu poses sent, %llu ticks without one\n", count(streamed->rows),
                count(streamed->held));
  }
  if (streamed->refused > 0) {
    throw Failure(kRefused, std::to_string(streamed->refused) +
                                " batches of poses were refused: " + streamed->first_refusal);
  }
}

}  // namespace

void add_pose_command(CLI::App& app, const GlobalOptions& options) {
  const auto choice = std::make_shared<PoseOptions>();
  CLI::App& command = *app.add_subcommand(
      "pose", "Moves the scripted device: rows x,y,z[,qw,qx,qy,qz] in metres, one per tick");
  command.add_option("FILE", choice->file, "table of poses, - for stdin")->capture_default_str();
  command.add_option("--tool", choice->tool, "id of the tool")->capture_default_str();
  command.callback([&options, choice] { pose(options, *choice); });
}

}  // namespace hapticd::ctl
