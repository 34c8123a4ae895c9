// haptic-audio: makes the sound of a running hapticd by JACK, or renders it to a file. Exit codes:
// 0 good, 1 a file is bad, 2 the command line makes no sense, 3 there is no JACK server.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "clients/audio/body_design.h"
#include "clients/audio/jack_output.h"
#include "clients/audio/live.h"
#include "clients/audio/options.h"
#include "clients/audio/render.h"
#include "clients/audio/sound_file.h"

namespace {

using namespace hapticd::audio;

/// --render.
int render_file(const Options& options) {
  std::string problem;
  const Score score =
      options.recording.empty() ? open_strings() : recorded_score(options.recording, problem);
  if (!problem.empty())
    std::fprintf(stderr, "haptic-audio: %s: %s\n", options.recording.c_str(), problem.c_str());
  if (score.empty()) return kFileBad;
  const Sound sound{options.rate_hz, gain_of(options), design_body(options.rate_hz)};
  const std::string folder = tones_folder(options);
  std::unique_ptr<ToneFiles> tones;
  if (!folder.empty()) tones = std::make_unique<ToneFiles>(folder, options.rate_hz);
  SoundFile file(options.render, options.rate_hz);
  const RenderReport report =
      render(score, sound, tones.get(), [&](std::span<const float> frames) { file.write(frames); });
  for (std::size_t i = 0; tones && i < tones->problems().size(); ++i) {
    std::fprintf(stderr, "haptic-audio: %s. The string is computed instead\n",
                 tones->problems()[i].c_str());
  }
  for (std::size_t i = 0; tones && i < tones->notes().size(); ++i)
    std::fprintf(stderr, "haptic-audio: %s\n", tones->notes()[i].c_str());
  std::fprintf(stderr,
               "haptic-audio: %.1f s, %llu tones, %llu unplayable, %llu lost, limited %.2f s\n",
               report.length_s, static_cast<unsigned long long>(report.played),
               static_cast<unsigned long long>(report.events.unplayable),
               static_cast<unsigned long long>(report.events.lost), report.limited_s);
  return 0;
}

int run(const Options& options) {
  if (options.tones && !std::filesystem::is_directory(*options.tones)) {
    std::fprintf(stderr, "haptic-audio: --tones: there is no folder %s\n", options.tones->c_str());
    return kFileBad;
  }
  if (!options.render_tones.empty()) {
    render_tone_files(options.render_tones, options.rate_hz);
    return 0;
  }
  if (!options.render.empty()) return render_file(options);
  if (options.list) {
    list_ports(options.json);
    return 0;
  }
  return play_live(options);
}

std::function<int()> prepare(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  add_options(app, *options);
  return [options] {
    try {
      return run(*options);
    } catch (const NoJackServer& problem) {
      std::fprintf(stderr, "haptic-audio: %s\n", problem.what());
      return kNoServer;
    }
  };
}

}  // namespace

int main(int argc, char** argv) {
  return hapticd::client::run_program(
      {"haptic-audio", "Makes the sound of a running hapticd, by JACK.", prepare}, argc, argv);
}
