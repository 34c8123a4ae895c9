// See tone_files.h.
#include "clients/audio/tone_files.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <sndfile.hh>
#include <system_error>
#include <vector>

#include "clients/audio/resampling.h"
#include "clients/audio/sound_file.h"
#include "clients/audio/string_design.h"

namespace hapticd::audio {
namespace {

namespace fs = std::filesystem;

/// Longest recording that is read, s.
constexpr sf_count_t kMax_s = 600;
/// Sample rates that are read, Hz.
constexpr int kMinRate_hz = 4000;
constexpr int kMaxRate_hz = 768000;
/// Sound is scaled to 1, or to an integer of 32 bits.
constexpr double kMaxSample = 4.0e9;
/// A sample this many times the sound around it, leaving out its neighbours, is an error. A pluck
/// with a hard click has 30.
constexpr double kStrayRatio = 200.0;
constexpr double kStrayWidth_s = 1e-3;
/// What is 40 dB below the loudest sample is before the tone, unless it is shorter than this.
constexpr double kSilence = 0.01;
constexpr double kMinSilence_s = 5e-3;
/// Left before the onset, s.
constexpr double kBeforeOnset_s = 1e-3;

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

/// The frames of a file, mixed to mono.
std::vector<float> mixed(SndfileHandle& file) {
  const auto channels = static_cast<std::size_t>(file.channels());
  std::vector<float> frames(static_cast<std::size_t>(file.frames()) * channels);
  frames.resize(static_cast<std::size_t>(file.readf(frames.data(), file.frames())) * channels);
  std::vector<float> mono(frames.size() / channels);
  for (std::size_t i = 0; i < mono.size(); ++i) {
    double sum = 0.0;
    for (std::size_t c = 0; c < channels; ++c) sum += static_cast<double>(frames[i * channels + c]);
    mono[i] = static_cast<float>(sum / static_cast<double>(channels));
  }
  return mono;
}

/// The first sample that cannot be sound: NaN, infinite, or larger than the largest integer that
/// sound is scaled by.
std::optional<std::size_t> wrong_sample(const std::vector<float>& samples) {
  const auto wrong = std::find_if(samples.begin(), samples.end(), [](float sample) {
    return !(std::abs(static_cast<double>(sample)) <= kMaxSample);
  });
  if (wrong == samples.end()) return std::nullopt;
  return static_cast<std::size_t>(wrong - samples.begin());
}

/// Of the frames [first, last) without those around `but`.
double rms_of(const std::vector<float>& samples, std::size_t first, std::size_t last,
              std::size_t but = SIZE_MAX, std::size_t around = 0) {
  double power = 0.0;
  std::size_t count = 0;
  for (std::size_t i = first; i < std::min(last, samples.size()); ++i) {
    if (but != SIZE_MAX && i + around >= but && i <= but + around) continue;
    power += static_cast<double>(samples[i]) * static_cast<double>(samples[i]);
    ++count;
  }
  return count > 0 ? std::sqrt(power / static_cast<double>(count)) : 0.0;
}

std::size_t largest_of(const std::vector<float>& samples) {
  const auto largest = std::max_element(samples.begin(), samples.end(),
                                        [](float a, float b) { return std::abs(a) < std::abs(b); });
  return static_cast<std::size_t>(largest - samples.begin());
}

/// The largest sample when it is none of the sound: far above all that is around it.
std::optional<std::size_t> stray_sample(const std::vector<float>& samples, double rate_hz) {
  const std::size_t largest = largest_of(samples);
  const auto half = static_cast<std::size_t>(0.5 * kLevelWindow_s * rate_hz);
  const auto near = static_cast<std::size_t>(kStrayWidth_s * rate_hz);
  const std::size_t first = largest > half ? largest - half : 0;
  const double rest = rms_of(samples, first, largest + half, largest, near);
  const double size = std::abs(static_cast<double>(samples[largest]));
  if (size <= kStrayRatio * rest) return std::nullopt;
  return largest;
}

std::string written(float sample) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", static_cast<double>(sample));
  return text;
}

std::string at_time(std::size_t frame, double rate_hz) {
  return shortened(static_cast<double>(frame) / rate_hz) + " s";
}

/// Cuts off what comes before the tone; how much it was, frames.
std::size_t cut_silence(std::vector<float>& samples, double rate_hz) {
  const double audible = kSilence * std::abs(static_cast<double>(samples[largest_of(samples)]));
  std::size_t onset = 0;
  while (std::abs(static_cast<double>(samples[onset])) < audible) ++onset;
  if (static_cast<double>(onset) < kMinSilence_s * rate_hz) return 0;
  const auto before = static_cast<std::size_t>(kBeforeOnset_s * rate_hz);
  const std::size_t cut = onset - std::min(onset, before);
  samples.erase(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(cut));
  // What is left before the onset may be noise: it begins softly.
  for (std::size_t i = 0; i < before; ++i) {
    samples[i] *= static_cast<float>(i) / static_cast<float>(before);
  }
  return cut;
}

/// What is wrong with the samples of a file, empty when nothing is.
std::string fault_of(const std::vector<float>& samples, double rate_hz) {
  if (const auto wrong = wrong_sample(samples)) {
    return "has a sample that is not sound, " + written(samples[*wrong]) + " at " +
           at_time(*wrong, rate_hz) + ". Write the file again, or repair it in an editor";
  }
  if (samples.empty() || std::abs(samples[largest_of(samples)]) == 0.0F) return "is silent";
  if (const auto stray = stray_sample(samples, rate_hz)) {
    return "has a stray sample at " + at_time(*stray, rate_hz) + ", " + written(samples[*stray]) +
           ", far beyond the sound around it. Repair it in an editor";
  }
  return {};
}

/// Reads a file; returns what is wrong with it, empty when it is good. `note` says what was
/// changed.
std::string read(const fs::path& path, double rate_hz, ToneFile& tone, std::string& note) {
  SndfileHandle file(path.string());
  if (file.error() != SF_ERR_NO_ERROR) {
    return std::string("cannot be read: ") + file.strError() + ". Sounds are WAV or FLAC";
  }
  const int own_hz = file.samplerate();
  if (own_hz < kMinRate_hz || own_hz > kMaxRate_hz) {
    return "has a sample rate of " + std::to_string(own_hz) + " Hz. Between " +
           std::to_string(kMinRate_hz) + " and " + std::to_string(kMaxRate_hz) + " will do";
  }
  if (file.frames() > sf_count_t{own_hz} * kMax_s) return "is longer than ten minutes";
  std::vector<float> samples = mixed(file);
  if (std::string fault = fault_of(samples, own_hz); !fault.empty()) return fault;
  const std::size_t cut = cut_silence(samples, own_hz);
  if (cut > 0) {
    const long silence_ms = std::lround(1e3 * static_cast<double>(cut) / own_hz);
    note = "begins with " + std::to_string(silence_ms) + " ms of silence, which are cut off";
  }
  const double length_s = static_cast<double>(samples.size()) / own_hz;
  if (length_s < kMinTone_s) {
    return "is too short: " + shortened(length_s) + " s. A tone has " + shortened(kMinTone_s) +
           " s at least";
  }
  tone.samples = resampled(samples, own_hz, static_cast<int>(std::lround(rate_hz)));
  tone.frequency_hz = frequency_of(file.getString(SF_STR_COMMENT));
  const auto window = static_cast<std::size_t>(kLevelWindow_s * rate_hz);
  tone.rms = rms_of(tone.samples, 0, window);
  if (!(tone.rms > 1e-6)) return "is too soft. Make it louder";
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
  std::string note;
  const std::string problem =
      path ? read(*path, rate_hz_, tone, note) : std::string("is missing, and so is the .flac");
  if (problem.empty()) {
    if (!note.empty()) notes_.push_back(path->string() + ": " + note);
    return &files_.emplace_back(std::move(tone));
  }
  refused_.push_back(name);
  problems_.push_back((path ? *path : folder_ / (name + ".wav")).string() + ": " + problem);
  return nullptr;
}

}  // namespace hapticd::audio
