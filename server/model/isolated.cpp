// See isolated.h.
#include "server/model/isolated.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>

namespace hapticd {
namespace {

constexpr int kGood = 0;
constexpr int kThrown = 1;
constexpr int kLost = 2;

/// A file without a name, shared with the child.
class SharedBytes {
 public:
  SharedBytes() : file_(memfd_create("hapticd-model", MFD_CLOEXEC)) {
    if (file_ < 0) throw std::runtime_error("no memory to read into");
  }
  ~SharedBytes() { close(file_); }
  SharedBytes(const SharedBytes&) = delete;
  SharedBytes& operator=(const SharedBytes&) = delete;

  [[nodiscard]] bool write(const std::uint8_t* bytes, std::size_t count) const {
    while (count > 0) {
      const ssize_t written = ::write(file_, bytes, count);
      if (written <= 0) return false;
      bytes += written;
      count -= static_cast<std::size_t>(written);
    }
    return true;
  }
  [[nodiscard]] std::vector<std::uint8_t> read() const {
    const off_t size = lseek(file_, 0, SEEK_END);
    std::vector<std::uint8_t> bytes(size > 0 ? static_cast<std::size_t>(size) : 0);
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t got =
          pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
      if (got <= 0) throw std::runtime_error("the result of the reader was lost");
      done += static_cast<std::size_t>(got);
    }
    return bytes;
  }

 private:
  int file_;
};

void limit(unsigned cpu_seconds) {
  const rlimit time{cpu_seconds, cpu_seconds + 1};
  setrlimit(RLIMIT_CPU, &time);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // What an aborting library has to say is not for the user.
  if (std::freopen("/dev/null", "w", stderr) == nullptr) std::fclose(stderr);
  // A sanitizer's own handlers would take long to describe what is expected here.
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) {
    std::signal(number, SIG_DFL);
  }
}

int run_child(const std::function<std::vector<std::uint8_t>()>& work, const SharedBytes& out) {
  try {
    const std::vector<std::uint8_t> result = work();
    return out.write(result.data(), result.size()) ? kGood : kLost;
  } catch (const std::exception& error) {
    const std::string text = error.what();
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    return out.write(bytes.data(), bytes.size()) ? kThrown : kLost;
  }
}

}  // namespace

std::vector<std::uint8_t> run_isolated(const std::function<std::vector<std::uint8_t>()>& work,
                                       unsigned cpu_seconds) {
  const SharedBytes shared;
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process to read in");
  if (child == 0) {
    limit(cpu_seconds);
    _exit(run_child(work, shared));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    const bool slow = WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL;
    throw std::runtime_error(slow ? "the reader took too long or too much memory"
                                  : "the reader crashed");
  }
  if (WEXITSTATUS(status) == kThrown) {
    const std::vector<std::uint8_t> text = shared.read();
    throw std::runtime_error(std::string(text.begin(), text.end()));
  }
  if (WEXITSTATUS(status) != kGood) throw std::runtime_error("the reader crashed");
  return shared.read();
}

}  // namespace hapticd
