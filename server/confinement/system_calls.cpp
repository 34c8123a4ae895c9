// See system_calls.h.
#include "server/confinement/system_calls.h"

#include <sys/syscall.h>

#include <array>
#include <cstddef>

// Calls that x86-64 has beside the ones that took their place.
#ifdef __x86_64__
#define HAPTICD_OLD_CALL(name) SystemCall{__NR_##name, #name},
#else
#define HAPTICD_OLD_CALL(name)
#endif
#define HAPTICD_CALL(name) \
  SystemCall { __NR_##name, #name }

namespace hapticd {
namespace {

template <std::size_t... Sizes>
constexpr auto joined(const std::array<SystemCall, Sizes>&... groups) {
  std::array<SystemCall, (Sizes + ...)> all{};
  std::size_t at = 0;
  const auto add = [&](const auto& group) {
    for (const SystemCall& call : group) all[at++] = call;
  };
  (add(groups), ...);
  return all;
}

/// Memory, locks, time, signals, the own end. What a thread reads, writes and closes it has been
/// given: it opens nothing without a further call.
constexpr std::array kAll{
    HAPTICD_CALL(brk),
    HAPTICD_CALL(mmap),
    HAPTICD_CALL(munmap),
    HAPTICD_CALL(mremap),
    HAPTICD_CALL(mprotect),
    HAPTICD_CALL(madvise),
    HAPTICD_CALL(futex),
    HAPTICD_CALL(set_robust_list),
    HAPTICD_CALL(rseq),
    HAPTICD_CALL(restart_syscall),
    HAPTICD_CALL(exit),
    HAPTICD_CALL(exit_group),
    HAPTICD_CALL(clock_gettime),
    HAPTICD_CALL(clock_getres),
    HAPTICD_CALL(clock_nanosleep),
    HAPTICD_CALL(nanosleep),
    HAPTICD_CALL(gettimeofday),
    HAPTICD_CALL(sched_yield),
    HAPTICD_CALL(getcpu),
    HAPTICD_CALL(rt_sigreturn),
    HAPTICD_CALL(rt_sigprocmask),
    HAPTICD_CALL(rt_sigaction),
    HAPTICD_CALL(sigaltstack),
    HAPTICD_CALL(getpid),
    HAPTICD_CALL(gettid),
    HAPTICD_CALL(tgkill),
    HAPTICD_CALL(getrandom),
    HAPTICD_CALL(read),
    HAPTICD_CALL(write),
    HAPTICD_CALL(close),
};

constexpr std::array kWaiting{HAPTICD_OLD_CALL(poll) HAPTICD_CALL(ppoll)};

constexpr std::array kDatagrams{
    HAPTICD_CALL(recvfrom), HAPTICD_CALL(recvmsg), HAPTICD_CALL(recvmmsg),
    HAPTICD_CALL(sendto),   HAPTICD_CALL(sendmsg), HAPTICD_CALL(sendmmsg),
};

/// A report, or a feature report.
constexpr std::array kReports{HAPTICD_CALL(ioctl), HAPTICD_CALL(writev)};

constexpr std::array kReading{
    HAPTICD_OLD_CALL(open)      //
    HAPTICD_OLD_CALL(stat)      //
    HAPTICD_OLD_CALL(lstat)     //
    HAPTICD_OLD_CALL(access)    //
    HAPTICD_OLD_CALL(readlink)  //
    HAPTICD_CALL(openat),       //
    HAPTICD_CALL(newfstatat),   //
    HAPTICD_CALL(fstat),        //
    HAPTICD_CALL(statx),        //
    HAPTICD_CALL(statfs),       //
    HAPTICD_CALL(fstatfs),      //
    HAPTICD_CALL(lseek),        //
    HAPTICD_CALL(pread64),      //
    HAPTICD_CALL(readv),        //
    HAPTICD_CALL(writev),       //
    HAPTICD_CALL(fcntl),        //
    HAPTICD_CALL(getdents64),   //
    HAPTICD_CALL(faccessat),    //
    HAPTICD_CALL(faccessat2),   //
    HAPTICD_CALL(readlinkat),   //
    HAPTICD_CALL(getcwd),       //
    HAPTICD_CALL(ioctl),        //
    HAPTICD_CALL(fadvise64),    //
    HAPTICD_CALL(flock),        //
    HAPTICD_CALL(uname),        //
    HAPTICD_CALL(sysinfo),      //
    HAPTICD_CALL(sched_getaffinity),
};

constexpr std::array kWriting{
    HAPTICD_OLD_CALL(mkdir)   //
    HAPTICD_OLD_CALL(unlink)  //
    HAPTICD_OLD_CALL(rmdir)   //
    HAPTICD_OLD_CALL(rename)  //
    HAPTICD_CALL(mkdirat),    //
    HAPTICD_CALL(unlinkat),   //
    HAPTICD_CALL(renameat),   //
    HAPTICD_CALL(renameat2),  //
    HAPTICD_CALL(pwrite64),   //
    HAPTICD_CALL(ftruncate),  //
    HAPTICD_CALL(fallocate),  //
    HAPTICD_CALL(fsync),      //
    HAPTICD_CALL(fdatasync),  //
    HAPTICD_CALL(umask),
};

/// To the journal, systemd, udev and avahi-daemon.
constexpr std::array kTalking{
    HAPTICD_CALL(socket),      HAPTICD_CALL(connect),     HAPTICD_CALL(bind),
    HAPTICD_CALL(getsockname), HAPTICD_CALL(getpeername), HAPTICD_CALL(getsockopt),
    HAPTICD_CALL(setsockopt),  HAPTICD_CALL(sendto),      HAPTICD_CALL(sendmsg),
    HAPTICD_CALL(recvfrom),    HAPTICD_CALL(recvmsg),     HAPTICD_CALL(shutdown),
    HAPTICD_CALL(getuid),      HAPTICD_CALL(geteuid),     HAPTICD_CALL(getgid),
    HAPTICD_CALL(getegid),     HAPTICD_CALL(memfd_create)};

/// libavahi, which watches its own configuration.
constexpr std::array kAvahi{
    HAPTICD_OLD_CALL(inotify_init)    //
    HAPTICD_OLD_CALL(pipe)            //
    HAPTICD_CALL(inotify_init1),      //
    HAPTICD_CALL(inotify_add_watch),  //
    HAPTICD_CALL(inotify_rm_watch),   //
    HAPTICD_CALL(pipe2),              //
    HAPTICD_CALL(eventfd2),           //
    HAPTICD_CALL(prlimit64),
};

constexpr std::array kEvents{
    HAPTICD_OLD_CALL(epoll_wait)    //
    HAPTICD_CALL(epoll_pwait),      //
    HAPTICD_CALL(epoll_ctl),        //
    HAPTICD_CALL(epoll_create1),    //
    HAPTICD_CALL(timerfd_create),   //
    HAPTICD_CALL(timerfd_settime),  //
    HAPTICD_CALL(eventfd2),
};

/// A thread is made, and confined; a priority is not given.
constexpr std::array kThreads{
    HAPTICD_CALL(clone),   HAPTICD_CALL(clone3), HAPTICD_CALL(prctl),
    HAPTICD_CALL(seccomp), HAPTICD_CALL(capget), HAPTICD_CALL(capset),
};

/// A key is kept where it is not swapped out, and let go.
constexpr std::array kSecrets{HAPTICD_CALL(mlock), HAPTICD_CALL(munlock)};

/// What is done once, or by a library of whose threads nothing is known.
constexpr std::array kStarting{
    HAPTICD_OLD_CALL(select)           //
    HAPTICD_OLD_CALL(epoll_create)     //
    HAPTICD_OLD_CALL(dup2)             //
    HAPTICD_CALL(dup),                 //
    HAPTICD_CALL(dup3),                //
    HAPTICD_CALL(pselect6),            //
    HAPTICD_CALL(accept4),             //
    HAPTICD_CALL(listen),              //
    HAPTICD_CALL(socketpair),          //
    HAPTICD_CALL(mlock2),              //
    HAPTICD_CALL(mlockall),            //
    HAPTICD_CALL(munlockall),          //
    HAPTICD_CALL(sched_setaffinity),   //
    HAPTICD_CALL(sched_setscheduler),  //
    HAPTICD_CALL(sched_setparam),      //
    HAPTICD_CALL(sched_getscheduler),  //
    HAPTICD_CALL(sched_getparam),      //
    HAPTICD_CALL(sched_get_priority_max),
    HAPTICD_CALL(sched_get_priority_min),
    HAPTICD_CALL(setpriority),      //
    HAPTICD_CALL(getpriority),      //
    HAPTICD_CALL(getrusage),        //
    HAPTICD_CALL(times),            //
    HAPTICD_CALL(getppid),          //
    HAPTICD_CALL(timer_create),     //
    HAPTICD_CALL(timer_settime),    //
    HAPTICD_CALL(timer_delete),     //
    HAPTICD_CALL(timerfd_gettime),  //
    HAPTICD_CALL(rt_sigtimedwait),  //
    HAPTICD_CALL(set_tid_address),
};

// Sleep and processor time are everyone's. A device is read and waited for; the wake-up of the
// writer, of the network and of a device port is a write.
constexpr auto kHaptic = kWaiting;
constexpr auto kStop = joined(kWaiting, kDatagrams);
constexpr auto kWriter = joined(kWaiting, kReports);
constexpr auto kAttachment = joined(kWaiting, kReading, kTalking);
constexpr auto kRecorder = joined(kWaiting, kReading, kWriting, kTalking);
constexpr auto kBuilder = joined(kWaiting, kReading, kTalking);
constexpr auto kAnnouncer = joined(kWaiting, kReading, kTalking, kAvahi);
constexpr auto kNetwork =
    joined(kWaiting, kDatagrams, kReading, kWriting, kTalking, kAvahi, kEvents, kThreads, kSecrets);
constexpr auto kStart = joined(kNetwork, kStarting);

struct Row {
  std::string_view name;
  std::span<const SystemCall> calls;
};

/// In the order of ThreadRole.
constexpr std::array<Row, kThreadRoles> kRows{{{"haptic", kHaptic},
                                               {"guardian", {}},
                                               {"stop", kStop},
                                               {"writer", kWriter},
                                               {"attachment", kAttachment},
                                               {"recorder", kRecorder},
                                               {"builder", kBuilder},
                                               {"announcer", kAnnouncer},
                                               {"network", kNetwork},
                                               {"start", kStart}}};

}  // namespace

std::span<const SystemCall> calls_of_all() noexcept { return kAll; }

std::span<const SystemCall> calls_of(ThreadRole role) noexcept {
  return kRows[static_cast<std::size_t>(role)].calls;
}

std::string_view name_of(ThreadRole role) noexcept {
  return kRows[static_cast<std::size_t>(role)].name;
}

}  // namespace hapticd
