// Recorded tones: a folder with one sound file per string, NAME.wav or NAME.flac, NAME as in the
// scene. A file is played at its own pitch when the string sounds as it was tuned, else faster or
// slower. Its level is measured, so that recordings and computed strings of the same event are
// equally loud. A file of another sample rate is resampled, silence before the tone is cut off, and
// one with samples that are not sound is refused. Samples are kept until the end of the program:
// voices read them. Not RT.
#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <vector>

namespace hapticd::audio {

/// Shorter recordings are refused: their level cannot be measured.
inline constexpr double kMinTone_s = 0.5;

/// One recording, mixed to mono.
struct ToneFile {
  std::string name;            ///< of the string
  std::vector<float> samples;  ///< at the output's sample rate
  double frequency_hz = 0.0;   ///< as the file says; 0: it does not
  double rms = 0.0;            ///< of its first kLevelWindow_s
};

/// The recordings of one folder, each read when it is first asked for.
class ToneFiles {
 public:
  ToneFiles(std::filesystem::path folder, double rate_hz)
      : folder_(std::move(folder)), rate_hz_(rate_hz) {}

  /// The recording of the string `name`; null when it cannot be played, which is said once in
  /// problems().
  const ToneFile* find(const std::string& name);
  /// What is wrong with the files asked for so far, and what to do: one line each.
  [[nodiscard]] const std::vector<std::string>& problems() const noexcept { return problems_; }
  /// What was changed of files that are played: one line each.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }

 private:
  std::filesystem::path folder_;
  double rate_hz_;
  std::deque<ToneFile> files_;        ///< a deque: what voices point to never moves
  std::vector<std::string> refused_;  ///< names
  std::vector<std::string> problems_;
  std::vector<std::string> notes_;
};

}  // namespace hapticd::audio
