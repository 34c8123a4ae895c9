// See tone_files.h.
#include "clients/audio/tone_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sndfile.hh>
#include <system_error>

#include "clients/audio/sound_file.h"
#include "clients/audio/string_design.h"

namespace hapticd::audio {
namespace {

namespace fs = std::filesystem;

/// Longest recording that is read: ten minutes at 192 kHz.
constexpr sf_count_t kMostFrames = sf_count_t{192000} * 600;

/// The file of a string, as it is called; none when there is none. A name that leads out of the
/// folder has none.
std::optional<fs::path> file_of(const fs::path& folder, const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos || name.starts_with('.'))
    return std::nullopt;
  for (const char* const ending : {".wav", ".flac", ".WAV", ".FLAC"}) {
    std::error_code ignored;
    fs::path file = folder / (name + ending);
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return std::nullopt;
}

std::string shortened(double number) {
  std::string text = std::to_string(number);
  text.erase(std::min(text.size(), text.find('.') + 3));
  return text;
}

/// Reads a file; returns what is wrong with it, empty when it is good.
std::string read(const fs::path& path, double rate_hz, ToneFile& tone) {
  SndfileHandle file(path.string());
  if (file.error() != SF_ERR_NO_ERROR) {
    return std::string("cannot be read: ") + file.strError() + ". Sounds are WAV or FLAC";
  }
  const int rate = static_cast<int>(std::lround(rate_hz));
  if (file.samplerate() != rate) {
    return "has " + std::to_string(file.samplerate()) + " Hz, the output " + std::to_string(rate) +
           " Hz. Convert it: sox " + path.filename().string() + " -r " + std::to_string(rate) +
           " NEW" + path.extension().string();
  }
  if (file.frames() > kMostFrames) return "is longer than ten minutes";
  const double length_s = static_cast<double>(file.frames()) / rate_hz;
  if (length_s < kShortestTone_s) {
    return "is too short: " + shortened(length_s) + " s. A tone has " + shortened(kShortestTone_s) +
           " s at least";
  }
  const auto channels = static_cast<std::size_t>(file.channels());
  std::vector<float> frames(static_cast<std::size_t>(file.frames()) * channels);
  frames.resize(static_cast<std::size_t>(file.readf(frames.data(), file.frames())) * channels);
  tone.samples.resize(frames.size() / channels);
  for (std::size_t i = 0; i < tone.samples.size(); ++i) {
    float sum = 0.0F;
    for (std::size_t c = 0; c < channels; ++c) sum += frames[i * channels + c];
    tone.samples[i] = sum / static_cast<float>(channels);
  }
  tone.frequency_hz = frequency_of(file.getString(SF_STR_COMMENT));
  const auto window =
      std::min(tone.samples.size(), static_cast<std::size_t>(kLevelWindow_s * rate_hz));
  double power = 0.0;
  for (std::size_t i = 0; i < window; ++i) {
    power += static_cast<double>(tone.samples[i]) * static_cast<double>(tone.samples[i]);
  }
  tone.rms = std::sqrt(power / static_cast<double>(window));
  if (!(tone.rms > 1e-6))
    return "is silent, or begins with silence. Cut it to where the tone begins";
  return {};
}

}  // namespace

const ToneFile* ToneFiles::find(const std::string& name) {
  const auto known = std::find_if(files_.begin(), files_.end(),
                                  [&](const ToneFile& file) { return file.name == name; });
  if (known != files_.end()) return &*known;
  if (std::find(refused_.begin(), refused_.end(), name) != refused_.end()) return nullptr;
  const std::optional<fs::path> path = file_of(folder_, name);
  ToneFile tone;
  tone.name = name;
  const std::string problem =
      path ? read(*path, rate_hz_, tone) : std::string("is missing, and so is the .flac");
  if (problem.empty()) return &files_.emplace_back(std::move(tone));
  refused_.push_back(name);
  problems_.push_back((path ? *path : folder_ / (name + ".wav")).string() + ": " + problem);
  return nullptr;
}

}  // namespace hapticd::audio
