// The keys of the daemon as its folder has them now: those of clients come and go while it runs.
// Whether files have changed is seen by their names, times, sizes and modes, without opening them.
// Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/noise/client_keys.h"

namespace hapticd {

class KeyWatch {
 public:
  /// Reads the folder. Throws std::runtime_error as noise::read_key_folder() does; what is wrong
  /// with keys of clients is in problems().
  explicit KeyWatch(std::filesystem::path folder);

  /// Looks at most twice a second; whether keys() are others than before. `now_ns` never goes back.
  bool follow(std::int64_t now_ns);

  [[nodiscard]] const noise::ServerKeys& keys() const noexcept { return keys_; }
  /// What is wrong with keys of clients, as of the newest reading.
  [[nodiscard]] const std::vector<std::string>& problems() const noexcept { return problems_; }

 private:
  /// A file, as far as it is seen without being opened.
  struct Seen {
    std::string name;
    std::array<std::int64_t, 5> facts{};  ///< inode, times of change and content, size, mode

    friend bool operator==(const Seen&, const Seen&) = default;
  };

  [[nodiscard]] std::vector<Seen> look() const;
  void read();

  std::filesystem::path folder_;
  noise::ServerKeys own_;  ///< without those of clients
  noise::ServerKeys keys_;
  std::vector<std::string> problems_;
  std::vector<Seen> seen_;
  std::int64_t due_ns_ = 0;
};

}  // namespace hapticd
