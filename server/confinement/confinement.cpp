// See confinement.h.
#include "server/confinement/confinement.h"

#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>
#include <system_error>

#include "core/rt/thread_role.h"
#include "server/confinement/system_calls.h"

namespace hapticd {
namespace {

#ifdef __x86_64__
constexpr std::uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kMachine = 0;  // no table: nothing is confined
#endif

#ifdef HAPTICD_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

Confinement chosen = Confinement::kOn;

/// The filter of a role: the machine, then two instructions a call.
struct Filter {
  static constexpr std::size_t kMost = 1024;
  std::array<sock_filter, kMost> code{};
  unsigned short length = 0;

  void add(std::uint16_t what, std::uint32_t value, std::uint8_t yes = 0, std::uint8_t no = 0) {
    if (length < kMost) code[length++] = {what, yes, no, value};
  }
  void let(std::span<const SystemCall> calls) {
    for (const SystemCall& call : calls) {
      add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call.number), 0, 1);
      add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    }
  }
};

Filter filter_of(ThreadRole role) {
  const std::uint32_t otherwise =
      chosen == Confinement::kStrict ? SECCOMP_RET_TRAP : SECCOMP_RET_ERRNO | ENOSYS;
  Filter filter;
  filter.add(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch));
  filter.add(BPF_JMP | BPF_JEQ | BPF_K, kMachine, 1, 0);
  filter.add(BPF_RET | BPF_K, otherwise);
  filter.add(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  filter.let(calls_of(role));
  filter.let(calls_of_all());
  filter.add(BPF_RET | BPF_K, otherwise);
  return filter;
}

/// Of what the user who started it had: root opens files and devices as root does, and memory that
/// is asked for later is locked as that of the start is. Priorities, and a port that is not
/// everyone's, are had at the start.
std::uint64_t capabilities_of(ThreadRole role) {
  constexpr std::uint64_t kMemory = 1U << CAP_IPC_LOCK;
  constexpr std::uint64_t kFiles = 1U << CAP_DAC_OVERRIDE | 1U << CAP_DAC_READ_SEARCH | kMemory;
  switch (role) {
    case ThreadRole::kStart:
      return kFiles | 1U << CAP_SYS_NICE | 1U << CAP_NET_BIND_SERVICE;
    case ThreadRole::kNetwork:
    case ThreadRole::kRecorder:
    case ThreadRole::kBuilder:
    case ThreadRole::kAttachment:
      return kFiles;
    case ThreadRole::kStop:
    case ThreadRole::kWriter:
    case ThreadRole::kAnnouncer:
      return kMemory;
    case ThreadRole::kHaptic:
    case ThreadRole::kGuardian:
      return 0;
  }
  return 0;
}

void give_up_capabilities(std::uint64_t kept) noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> data{};
  if (syscall(SYS_capget, &header, data.data()) != 0) return;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const auto mask = static_cast<std::uint32_t>(kept >> (32 * k));
    data[k].permitted &= mask;
    data[k].effective &= mask;
    data[k].inheritable = 0;
  }
  syscall(SYS_capset, &header, data.data());
}

/// A line on stderr, put together without memory and written by what every role may call.
class Line {
 public:
  void put(std::string_view words) {
    for (const char c : words) {
      if (length_ < text_.size()) text_[length_++] = c;
    }
  }
  void put(unsigned number) {
    std::array<char, 12> digits{};
    std::size_t count = 0;
    do digits[count++] = static_cast<char>('0' + number % 10);
    while ((number /= 10) > 0);
    while (count > 0) put({&digits[--count], 1});
  }
  void write() { static_cast<void>(!::write(STDERR_FILENO, text_.data(), length_)); }

 private:
  std::array<char, 160> text_{};
  std::size_t length_ = 0;
};

/// False with errno. A unit of systemd may let the older way pass alone.
bool set_filter(const sock_fprog& program) noexcept {
  // Without the flag kernels before 5.16 slow the whole thread down.
  return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_SPEC_ALLOW, &program) ==
             0 ||
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

void confine(ThreadRole role) noexcept {
  give_up_capabilities(capabilities_of(role));
  Filter filter = filter_of(role);
  if (set_filter({filter.length, filter.code.data()})) return;
  Line line;
  line.put("hapticd: a thread could not be confined to its role, ");
  line.put(name_of(role));
  line.put(": error ");
  line.put(static_cast<unsigned>(errno));
  line.put("\n");
  line.write();
}

/// Ends the process.
void on_forbidden_call(int /*signal*/, siginfo_t* info, void* /*context*/) {
  Line line;
  line.put("hapticd: a thread made system call ");
  line.put(static_cast<unsigned>(info->si_syscall));
  line.put(", which its role has not\n");
  line.write();
  _exit(128 + SIGSYS);
}

std::string refusal(const char* what) {
  return std::string(what) + ": " + std::generic_category().message(errno);
}

}  // namespace

void choose_confinement(Confinement how) noexcept { chosen = how; }

std::string begin_confinement() {
  if (chosen == Confinement::kOff) return "";
  if (kSanitized) return "threads are not confined: a sanitizer asks the kernel for more";
  if (kMachine == 0) return "threads are not confined: no table for this machine";
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return refusal("threads are not confined");
  if (prctl(PR_GET_SECCOMP, 0, 0, 0, 0) < 0) {
    return refusal("threads are not confined to their system calls");
  }
  if (chosen == Confinement::kStrict) {
    struct sigaction trap {};
    trap.sa_sigaction = on_forbidden_call;
    trap.sa_flags = SA_SIGINFO;
    sigaction(SIGSYS, &trap, nullptr);
  }
  confine_thread.store(confine, std::memory_order_release);
  return "";
}

}  // namespace hapticd
