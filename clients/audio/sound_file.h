// Sound written to a file, by libsndfile: WAV with 32-bit floating point, or FLAC with 24 bits. The
// same frames give the same bytes: no date is written. Not RT.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

class SndfileHandle;

namespace hapticd::audio {

/// A file that is being written. Throws std::runtime_error with the file's name and the reason.
class SoundFile {
 public:
  /// Mono. `path` ends in .wav or .flac. `frequency_hz`: pitch of the tone in it, which
  /// frequency_of() finds again; 0: none.
  SoundFile(const std::filesystem::path& path, double rate_hz, double frequency_hz = 0.0);
  ~SoundFile();
  SoundFile(const SoundFile&) = delete;
  SoundFile& operator=(const SoundFile&) = delete;

  void write(std::span<const float> frames);

 private:
  std::filesystem::path path_;
  std::unique_ptr<SndfileHandle> file_;
};

/// The pitch that a file's comment names, Hz; 0 when it names none. Null: there is no comment.
[[nodiscard]] double frequency_of(const char* comment);

}  // namespace hapticd::audio
