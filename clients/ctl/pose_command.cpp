// pose: a table of poses becomes the motion of the scripted device, a row a tick. Under the virtual
// clock the ticks are run as the poses come; under the real clock rows are sent as fast as ticks
// pass. Not RT.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/ctl/commands.h"
#include "clients/ctl/pose_row.h"
#include "clients/ctl/text.h"
#include "proto/hints/whole_number_option.h"

namespace hapticd::ctl {
namespace {

/// Ticks run at once under the virtual clock.
constexpr std::uint64_t kTicksPerRun = 140;
/// Rows sent ahead of the real clock, s: a hiccup of the network shorter than this is not felt.
constexpr double kAhead = 0.1;

/// The table that comes on stdin.
constexpr const char* kStdin = "-";

struct PoseOptions {
  std::string file = kStdin;
  std::uint32_t tool = 0;
};

/// What became of the rows.
struct Streamed {
  std::uint64_t rows = 0;
  std::uint64_t refused = 0;
  std::uint64_t held = 0;
  std::string first_refusal;
};

/// A table, read row by row as it comes.
class PoseTable {
 public:
  /// `input` outlives this; it is the file of that name, or stdin.
  PoseTable(std::istream& input, const std::string& file)
      : input_(input), place_{file == kStdin ? "" : file, 0}, first_(read()) {
    if (first_) return;
    throw Failure(kRefused, (place_.file.empty() ? "stdin" : place_.file) +
                                ": there is no pose in it. Give rows x,y,z in metres.");
  }

  /// The next pose, of which there is one in any table; nothing at its end.
  std::optional<v1::Pose> take() {
    auto first = std::exchange(first_, std::nullopt);
    return first ? first : read();
  }

 private:
  std::optional<v1::Pose> read() {
    for (std::string line; std::getline(input_, line);) {
      ++place_.line;
      auto pose = parse_pose(line, place_);
      if (pose) return pose;
    }
    return std::nullopt;
  }

  std::istream& input_;
  RowPlace place_;
  std::optional<v1::Pose> first_;  ///< until it is taken
};

void run_ticks(client::Controller& controller, std::uint64_t ticks, const GlobalOptions& options,
               Streamed& streamed) {
  if (ticks == 0) return;
  const v1::Result result = controller.run(ticks, timeout_of(options));
  require(result);
  streamed.held += result.run().held_inputs();
}

void stream(PoseTable& table, const PoseOptions& choice, const GlobalOptions& options,
            client::Client& client, Streamed& streamed) {
  client::Controller controller(client);
  acquire(controller, client, options);
  const bool lockstep = client.scene()->clock() == v1::CLOCK_MODE_VIRTUAL;
  const double rate = client.scene()->rate_hz() > 0.0 ? client.scene()->rate_hz() : 1000.0;
  const std::int64_t began_ns = client::monotonic_now_ns();
  std::uint64_t unrun = 0;
  while (const auto pose = table.take()) {
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
  if (choice.file != kStdin) file = open_file(choice.file);
  PoseTable table(choice.file == kStdin ? std::cin : file, choice.file);
  const auto client = connect(options, handlers);
  stream(table, choice, options, *client, *streamed);
  const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  if (options.json) {
    const nlohmann::ordered_json json = {{"rows", streamed->rows},
                                         {"refused_batches", streamed->refused},
                                         {"held_inputs", streamed->held}};
    print_text(to_json(json));
  } else {
    std::printf("%llu pose%s sent, %llu tick%s without one\n", count(streamed->rows),
                streamed->rows == 1 ? "" : "s", count(streamed->held),
                streamed->held == 1 ? "" : "s");
  }
  if (streamed->refused > 0) {
    throw Failure(kRefused,
                  std::to_string(streamed->refused) +
                      (streamed->refused == 1 ? " batch of poses was" : " batches of poses were") +
                      " refused: " + streamed->first_refusal);
  }
}

}  // namespace

void add_pose_command(CLI::App& app, const GlobalOptions& options) {
  const auto choice = std::make_shared<PoseOptions>();
  CLI::App& command = *app.add_subcommand(
      "pose", "Moves the scripted device: rows x,y,z[,qw,qx,qy,qz] in metres, one per tick");
  command.add_option("FILE", choice->file, "table of poses, - for stdin")->capture_default_str();
  hints::takes_whole_number(command.add_option("--tool", choice->tool, "id of the tool"), 0,
                            kMaxToolId)
      ->capture_default_str();
  command.callback([&options, choice] { pose(options, *choice); });
}

}  // namespace hapticd::ctl
