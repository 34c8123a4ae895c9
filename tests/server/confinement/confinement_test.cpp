// What a thread of each role is refused. Filters are of threads: this process stays as it is.
#include "server/confinement/confinement.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "server/confinement/landlock.h"
#include "server/confinement/system_calls.h"

namespace hapticd::test {
namespace {

bool begun(Confinement how) {
  choose_confinement(how);
  return begin_confinement().empty();
}

/// errno of a call that a thread of this role makes; 0: it succeeds.
int tried_as(ThreadRole role, const std::function<long()>& call) {
  REQUIRE(begun(Confinement::kOn));
  int code = -1;
  std::thread([&] {
    begin_role(role);
    errno = 0;
    code = call() < 0 ? errno : 0;
  }).join();
  confine_thread.store(nullptr);
  return code;
}

long run_a_program() {
  const char* const none[] = {nullptr};
  return syscall(SYS_execve, "/bin/true", none, none);
}
long open_a_file() { return syscall(SYS_openat, AT_FDCWD, "/etc/shadow", O_RDONLY | O_CLOEXEC); }
long make_a_socket() { return syscall(SYS_socket, AF_INET, SOCK_DGRAM, 0); }
long look_into_a_process() { return syscall(SYS_ptrace, PTRACE_SEIZE, getppid(), 0, 0); }
long make_a_thread() { return syscall(SYS_clone3, nullptr, 0); }

std::array<ThreadRole, kThreadRoles> all_roles() {
  std::array<ThreadRole, kThreadRoles> roles{};
  for (std::size_t k = 0; k < roles.size(); ++k) roles[k] = static_cast<ThreadRole>(k);
  return roles;
}

bool has(std::span<const SystemCall> calls, int number) {
  return std::any_of(calls.begin(), calls.end(),
                     [&](const SystemCall& call) { return call.number == number; });
}

/// The exit code of a process that does `work`; of a signal that ends it, 1000 and its number.
int exit_code_of(const std::function<int()>& work) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    // The test framework's handler is not the program's.
    static_cast<void>(std::signal(SIGABRT, SIG_DFL));
    ::_exit(work());
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

TEST_CASE("no thread of any role runs a program, looks into a process or mounts anything") {
  for (const ThreadRole role : all_roles()) {
    INFO("role ", std::string(name_of(role)));
    CHECK(tried_as(role, run_a_program) == ENOSYS);
    CHECK(tried_as(role, look_into_a_process) == ENOSYS);
    CHECK(tried_as(role, [] { return syscall(SYS_mount, "", "", "", 0, nullptr); }) == ENOSYS);
    CHECK(tried_as(role, [] { return syscall(SYS_setuid, 0); }) == ENOSYS);
    CHECK(tried_as(role, [] { return syscall(SYS_bpf, 0, nullptr, 0); }) == ENOSYS);
  }
}

TEST_CASE("of all calls there are no role makes one that is not in its table") {
  constexpr int kBeyondTheLast = 1000;
  // uretprobe and uprobe of x86-64: newer kernels let them pass every filter, and kill who makes
  // them from anywhere but their own probes.
  constexpr std::array kOfProbes{335, 336};
  for (const ThreadRole role : all_roles()) {
    INFO("role ", std::string(name_of(role)));
    std::string made;
    const auto call_all = [&]() -> long {
      for (int number = 0; number < kBeyondTheLast; ++number) {
        if (has(calls_of(role), number) || has(calls_of_all(), number)) continue;
        if (std::find(kOfProbes.begin(), kOfProbes.end(), number) != kOfProbes.end()) continue;
        errno = 0;
        if (syscall(number, -1, 0, 0, 0, 0, 0) == -1 && errno == ENOSYS) continue;
        made += " " + std::to_string(number);
      }
      return 0;
    };
    CHECK(tried_as(role, call_all) == 0);
    CHECK(made.empty());
  }
}

TEST_CASE("the threads that are on time open nothing, and make neither sockets nor threads") {
  for (const ThreadRole role :
       {ThreadRole::kHaptic, ThreadRole::kGuardian, ThreadRole::kStop, ThreadRole::kWriter}) {
    INFO("role ", std::string(name_of(role)));
    CHECK(tried_as(role, open_a_file) == ENOSYS);
    CHECK(tried_as(role, make_a_socket) == ENOSYS);
    CHECK(tried_as(role, make_a_thread) == ENOSYS);
  }
}

TEST_CASE("a haptic thread sleeps, tells its time, reads a device and wakes the writer") {
  const int event = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  REQUIRE(event >= 0);
  const auto work = [&]() -> long {
    const timespec short_while{0, 1000};
    timespec used{};
    std::uint64_t count = 1;
    if (clock_nanosleep(CLOCK_MONOTONIC, 0, &short_while, nullptr) != 0) return -1;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used) != 0) return -1;
    if (::write(event, &count, sizeof(count)) < 0) return -1;
    return ::read(event, &count, sizeof(count));
  };
  CHECK(tried_as(ThreadRole::kHaptic, work) == 0);
  close(event);
}

TEST_CASE("whoever writes or reads files may open them") {
  for (const ThreadRole role :
       {ThreadRole::kRecorder, ThreadRole::kBuilder, ThreadRole::kNetwork, ThreadRole::kStart}) {
    INFO("role ", std::string(name_of(role)));
    const auto look = [] { return syscall(SYS_openat, AT_FDCWD, "/", O_RDONLY | O_CLOEXEC); };
    CHECK(tried_as(role, look) == 0);
  }
}

TEST_CASE("the network keeps no capability but those for files and locked memory") {
  const auto effective = [](ThreadRole role) {
    std::uint32_t left = ~0U;
    const auto call = [&]() -> long {
      __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
      std::array<__user_cap_data_struct, 2> data{};
      const long done = syscall(SYS_capget, &header, data.data());
      left = data[0].effective | data[1].effective;
      return done;
    };
    static_cast<void>(tried_as(role, call));
    return left;
  };
  constexpr std::uint32_t kMost =
      1U << CAP_DAC_OVERRIDE | 1U << CAP_DAC_READ_SEARCH | 1U << CAP_IPC_LOCK;
  CHECK((effective(ThreadRole::kNetwork) & ~kMost) == 0);
}

TEST_CASE("no role has a call that those it is made by have not") {
  for (const ThreadRole role : all_roles()) {
    for (const SystemCall& call : calls_of(role)) {
      INFO("role ", std::string(name_of(role)), ", call ", std::string(call.name));
      CHECK(has(calls_of(ThreadRole::kStart), call.number));
    }
  }
  for (const SystemCall& call : calls_of(ThreadRole::kBuilder)) {
    INFO("call ", std::string(call.name));
    CHECK(has(calls_of(ThreadRole::kNetwork), call.number));
  }
}

TEST_CASE("a thread that a library makes has what its maker has, and no more") {
  for (const ThreadRole role : {ThreadRole::kStart, ThreadRole::kNetwork}) {
    int opened = -1;
    int ran = 0;
    const auto make = [&]() -> long {
      std::thread([&] {
        opened = open_a_file() < 0 ? errno : 0;
        ran = run_a_program() < 0 ? errno : 0;
      }).join();
      return 0;
    };
    CHECK(tried_as(role, make) == 0);
    CHECK(opened != ENOSYS);
    CHECK(ran == ENOSYS);
  }
}

TEST_CASE("memory, threads' locks and a fatal signal work in every role") {
  for (const ThreadRole role : all_roles()) {
    INFO("role ", std::string(name_of(role)));
    CHECK(exit_code_of([&] {
            if (!begun(Confinement::kStrict)) return 1;
            begin_role(role);
            const std::unique_ptr<char[]> large(new char[32U << 20U]);
            large[1U << 20U] = 1;
            for (int k = 0; k < 100; ++k) delete[] new char[100'000];
            const timespec moment{0, 1000};
            nanosleep(&moment, nullptr);
            std::abort();
          }) == 1000 + SIGABRT);
  }
}

TEST_CASE("of the file system nothing is left but what was named") {
  const std::filesystem::path root =
      std::filesystem::temp_directory_path() / ("hapticd-confined-" + std::to_string(getpid()));
  for (const char* name : {"read", "written", "other"}) {
    std::filesystem::create_directories(root / name);
    std::ofstream(root / name / "file") << "text";
  }
  const auto can = [&](const char* folder, const char* file, int flags) {
    const int opened = ::open((root / folder / file).c_str(), flags | O_CLOEXEC, 0600);
    if (opened >= 0) ::close(opened);
    return opened >= 0;
  };
  const int code = exit_code_of([&] {
    if (!begun(Confinement::kOn)) return 1;
    const ReachedPath paths[] = {{root / "read"}, {root / "written", true}, {root / "not there"}};
    if (!reach_only(paths).empty()) return 2;
    int faults = 0;
    const auto want = [&](bool right) { faults += right ? 0 : 1; };
    want(can("read", "file", O_RDONLY));
    want(!can("read", "file", O_RDWR));
    want(!can("read", "new", O_WRONLY | O_CREAT));
    want(can("written", "file", O_RDWR));
    want(can("written", "new", O_WRONLY | O_CREAT));
    want(::unlink((root / "written" / "new").c_str()) == 0);
    want(!can("other", "file", O_RDONLY));
    want(::mkdir((root / "other" / "folder").c_str(), 0700) != 0);
    want(::mkdir((root / "written" / "folder").c_str(), 0700) == 0);
    return faults == 0 ? 0 : 10 + faults;
  });
  std::filesystem::remove_all(root);
  // A kernel that has no such means says so.
  const bool known = syscall(SYS_landlock_create_ruleset, nullptr, 0, 1) > 0;
  CHECK(code == (known ? 0 : 2));
}

TEST_CASE("a strict process ends with the call that was not in the table") {
  CHECK(exit_code_of([] {
          if (!begun(Confinement::kStrict)) return 1;
          begin_role(ThreadRole::kHaptic);
          make_a_socket();
          return 0;
        }) == 128 + SIGSYS);
}

TEST_CASE("threads that are not to be confined may do as before") {
  CHECK(begun(Confinement::kOff));
  const bool confines = confine_thread.load() != nullptr;
  CHECK_FALSE(confines);
}

}  // namespace
}  // namespace hapticd::test
