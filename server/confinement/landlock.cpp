// See landlock.h. Numbers are those of the kernel's interface: the headers of Debian 12 lack some.
#include "server/confinement/landlock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace hapticd {
namespace {

constexpr std::uint64_t kExecute = 1U << 0U;
constexpr std::uint64_t kWriteFile = 1U << 1U;
constexpr std::uint64_t kReadFile = 1U << 2U;
constexpr std::uint64_t kReadFolder = 1U << 3U;
constexpr std::uint64_t kRemoveFolder = 1U << 4U;
constexpr std::uint64_t kRemoveFile = 1U << 5U;
constexpr std::uint64_t kMakeDevice = 1U << 6U;
constexpr std::uint64_t kMakeFolder = 1U << 7U;
constexpr std::uint64_t kMakeFile = 1U << 8U;
constexpr std::uint64_t kMakeOther = 0xFU << 9U;  // sockets, pipes, block devices, links
constexpr std::uint64_t kRefer = 1U << 13U;
constexpr std::uint64_t kTruncate = 1U << 14U;
constexpr std::uint64_t kDeviceControl = 1U << 15U;

constexpr std::uint64_t kReads = kReadFile | kReadFolder;
constexpr std::uint64_t kWrites = kReads | kWriteFile | kRemoveFolder | kRemoveFile | kMakeFolder |
                                  kMakeFile | kTruncate | kDeviceControl;
/// What makes sense for a file that is no folder.
constexpr std::uint64_t kOfFiles = kReadFile | kWriteFile | kTruncate | kDeviceControl;

constexpr unsigned kAskVersion = 1;
constexpr int kBeneathPath = 1;

struct RulesetAttributes {
  std::uint64_t files = 0;
};

struct [[gnu::packed]] PathAttributes {
  std::uint64_t allowed = 0;
  std::int32_t folder = -1;
};

/// All that a version of the interface can refuse.
std::uint64_t refusable(long version) {
  std::uint64_t all = kExecute | kReads | kWriteFile | kRemoveFolder | kRemoveFile | kMakeDevice |
                      kMakeFolder | kMakeFile | kMakeOther;
  if (version >= 2) all |= kRefer;
  if (version >= 3) all |= kTruncate;
  if (version >= 5) all |= kDeviceControl;
  return all;
}

class Descriptor {
 public:
  explicit Descriptor(long number) noexcept : number_(static_cast<int>(number)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int number() const noexcept { return number_; }

 private:
  int number_;
};

/// False with errno.
bool allow(int ruleset, const ReachedPath& reached, std::uint64_t refused) {
  const Descriptor place(::open(reached.path.c_str(), O_PATH | O_CLOEXEC));
  if (place.number() < 0) return true;
  struct stat about {};
  if (::fstat(place.number(), &about) != 0) return false;
  std::uint64_t rights = (reached.writes ? kWrites : kReads) & refused;
  if (!S_ISDIR(about.st_mode)) rights &= kOfFiles;
  const PathAttributes rule{rights, place.number()};
  return syscall(SYS_landlock_add_rule, ruleset, kBeneathPath, &rule, 0) == 0;
}

bool limited = false;

std::string refusal() { return std::generic_category().message(errno); }

}  // namespace

std::string reach_only(std::span<const ReachedPath> paths) {
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, kAskVersion);
  if (version < 0) return refusal();
  const RulesetAttributes refused{refusable(version)};
  const Descriptor ruleset(syscall(SYS_landlock_create_ruleset, &refused, sizeof(refused), 0));
  if (ruleset.number() < 0) return refusal();
  for (const ReachedPath& path : paths) {
    if (!allow(ruleset.number(), path, refused.files)) {
      return path.path.string() + ": " + refusal();
    }
  }
  if (syscall(SYS_landlock_restrict_self, ruleset.number(), 0) != 0) return refusal();
  limited = true;
  return "";
}

std::string reach_remedy(std::string_view error) {
  const std::string reason = std::generic_category().message(EACCES);
  if (!limited || error.find(reason) == std::string_view::npos) return "";
  return std::string(error.ends_with('.') ? " " : ". ") +
         "A folder that the start did not name is out of reach, see --confine in man hapticd.";
}

}  // namespace hapticd
