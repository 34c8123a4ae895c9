// What status and watch show of a daemon, as lines of text. Pure. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/event.pb.h"
#include "hapticd/v1/state.pb.h"

namespace hapticd::ctl {

/// Thread CPU times of ticks in bins of doubling width: bin i holds times below 1000 2^i ns, and
/// the last all longer ones.
struct TickHistogram {
  std::array<std::uint64_t, 12> counts{};

  void add(std::uint32_t ns) noexcept;
};

/// All there is to show.
struct View {
  std::string server;
  v1::SceneInfo scene;
  v1::State state;
  bool has_state = false;
  v1::LeaseInfo lease;
  TickHistogram ticks;
  std::deque<v1::Tone> tones;  ///< newest first
  double silence_s = 0.0;      ///< since the daemon was heard
};

/// Head, tools, timing: what status prints.
[[nodiscard]] std::vector<std::string> summary_lines(const View& view);

/// What has happened on the network: the counts that are not 0, with their causes.
[[nodiscard]] std::string network_line(const v1::Counts& counts);

/// All of it for a terminal of this size: no line longer, no more lines.
[[nodiscard]] std::vector<std::string> screen_lines(const View& view, std::size_t columns,
                                                    std::size_t rows);

}  // namespace hapticd::ctl
