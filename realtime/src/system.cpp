#include "rollerrig/realtime/system.hpp"

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

#if defined(__linux__)
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "rollerrig_shm.h"

namespace rollerrig::realtime {
namespace {

constexpr std::int64_t second = 1'000'000'000;
constexpr int fifo_priority = 40;  ///< below the threads of the kernel's interrupts

std::int64_t read_clock(clockid_t which) {
  timespec t{};
  clock_gettime(which, &t);
  return second * static_cast<std::int64_t>(t.tv_sec) + t.tv_nsec;
}

sockaddr_in address_of(Peer peer) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = static_cast<std::uint32_t>(peer >> 16);
  address.sin_port = static_cast<std::uint16_t>(peer & 0xffff);
  return address;
}

constexpr int looks_before_sleep = 2000;  ///< some 50 us

/// The pages that the loop's calls will stand on.
void touch_stack() {
  unsigned char stack[256 * 1024];
  std::memset(stack, 0, sizeof stack);
  asm volatile("" : : "r"(stack) : "memory");  // nobody reads it: it is to be written all the same
}

[[noreturn]] void fail(int error, char const* what) { throw std::system_error(error, std::generic_category(), what); }

}  // namespace

void require_real_time() {}

UdpPort::UdpPort(std::string const& address, int port) {
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, address.c_str(), &own.sin_addr) != 1 || address.size() > 15)
    throw std::invalid_argument("RigServer: address must be one of IPv4, 127.0.0.1");
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) fail(errno, "socket");
  socklen_t size = sizeof own;
  if (::bind(socket_, reinterpret_cast<sockaddr*>(&own), size) != 0 ||
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) != 0) {
    int const error = errno;
    ::close(socket_);
    fail(error, "bind");
  }
  port_ = ntohs(own.sin_port);
}

UdpPort::~UdpPort() { ::close(socket_); }

std::ptrdiff_t UdpPort::receive(std::span<unsigned char> buffer, Peer& sender) {
  sockaddr_in from{};
  socklen_t size = sizeof from;
  ssize_t received = 0;
  do {  // an error of an earlier send, ECONNREFUSED, is reported here: it is not a datagram
    received = ::recvfrom(socket_, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
  } while (received < 0 && errno == ECONNREFUSED);
  if (received < 0) return -1;
  sender = static_cast<Peer>(from.sin_addr.s_addr) << 16 | from.sin_port;
  return received;
}

void UdpPort::send(std::span<unsigned char const> frame, Peer to) {
  sockaddr_in const address = address_of(to);
  // A controller that is not there is the watchdog's business.
  (void)::sendto(socket_, frame.data(), frame.size(), 0, reinterpret_cast<sockaddr const*>(&address), sizeof address);
}

void UdpPort::wait(std::int64_t ns) {
  pollfd one{socket_, POLLIN, 0};
  ::poll(&one, 1, static_cast<int>((ns + 999'999) / 1'000'000));
}

SharedMemoryPort::SharedMemoryPort(std::string const& name) : name_{name} {
  if (name.size() < 2 || name.size() > 200 || name[0] != '/' || name.find('/', 1) != std::string::npos ||
      name.find('\0') != std::string::npos)
    throw std::invalid_argument("RigServer: address must be /name, with no other '/', or one of IPv4");
  int const file = ::shm_open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) fail(errno, "shared memory");
  if (::ftruncate(file, RR_SHM_SIZE) == 0)
    memory_ = ::mmap(nullptr, RR_SHM_SIZE, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
  int const error = errno;
  ::close(file);
  if (memory_ == nullptr || memory_ == MAP_FAILED) {
    ::shm_unlink(name.c_str());
    fail(error, "shared memory");
  }
  std::memcpy(memory_, "RRIGSHM1", 8);
}

SharedMemoryPort::~SharedMemoryPort() {
  ::munmap(memory_, RR_SHM_SIZE);
  ::shm_unlink(name_.c_str());
}

std::ptrdiff_t SharedMemoryPort::receive(std::span<unsigned char> buffer, Peer& sender) {
  sender = 1;
  return rr_ring_get(rr_controller_ring(memory_), &next_, buffer.data(), buffer.size());
}

void SharedMemoryPort::send(std::span<unsigned char const> frame, Peer) {
  rr_ring_put(rr_server_ring(memory_), frame.data(), frame.size());
}

void SharedMemoryPort::wait(std::int64_t ns) {
  std::int64_t const until = read_clock(CLOCK_MONOTONIC) + ns;
  rr_ring* ring = rr_controller_ring(memory_);
  for (int looks = 0; __atomic_load_n(&ring->written, __ATOMIC_ACQUIRE) <= next_; ++looks) {
    if (read_clock(CLOCK_MONOTONIC) > until) return;
    if (looks < looks_before_sleep) continue;
    timespec const nap{0, 50'000};
    ::nanosleep(&nap, nullptr);
  }
}

std::int64_t DeadlineClock::now() const { return read_clock(CLOCK_MONOTONIC); }

void DeadlineClock::sleep_until(std::int64_t deadline) const {
  std::int64_t const wake = deadline - spin_;
  if (now() < wake) {
    timespec const t{static_cast<time_t>(wake / second), static_cast<long>(wake % second)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
    }
  }
  while (now() < deadline) {
  }
}

std::int64_t processor_time() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

RealTimePriority::RealTimePriority() {
  // What has been touched stays; to fetch all that a Python process has merely reserved would take seconds.
  locked_ = ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
  memory_ = locked_ ? "locked" : std::string("not locked: ") + std::strerror(errno);
  sched_param before{}, wanted{};
  pthread_getschedparam(pthread_self(), &policy_before_, &before);
  wanted.sched_priority = fifo_priority;
  int const error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  first_ = error == 0;
  touch_stack();
  scheduling_ = first_ ? "SCHED_FIFO" : std::string("ordinary: SCHED_FIFO: ") + std::strerror(error);
}

RealTimePriority::~RealTimePriority() {
  if (locked_) ::munlockall();
  sched_param ordinary{};
  if (first_) pthread_setschedparam(pthread_self(), policy_before_, &ordinary);
}

}  // namespace rollerrig::realtime

#else

namespace rollerrig::realtime {
namespace {
constexpr char const* missing = "not on this system: the server in real time is written for Linux";
}

void require_real_time() { throw std::runtime_error(missing); }
UdpPort::UdpPort(std::string const&, int) { require_real_time(); }
UdpPort::~UdpPort() = default;
std::ptrdiff_t UdpPort::receive(std::span<unsigned char>, Peer&) { return -1; }
void UdpPort::send(std::span<unsigned char const>, Peer) {}
void UdpPort::wait(std::int64_t) {}
SharedMemoryPort::SharedMemoryPort(std::string const&) { require_real_time(); }
SharedMemoryPort::~SharedMemoryPort() = default;
std::ptrdiff_t SharedMemoryPort::receive(std::span<unsigned char>, Peer&) { return -1; }
void SharedMemoryPort::send(std::span<unsigned char const>, Peer) {}
void SharedMemoryPort::wait(std::int64_t) {}
std::int64_t DeadlineClock::now() const { return 0; }
void DeadlineClock::sleep_until(std::int64_t) const {}
std::int64_t processor_time() { return 0; }
RealTimePriority::RealTimePriority() : memory_{missing}, scheduling_{missing} {}
RealTimePriority::~RealTimePriority() = default;

}  // namespace rollerrig::realtime

#endif

namespace rollerrig::realtime {

AnyPort::AnyPort(std::string const& address, int port) {
  if (address.starts_with('/'))
    memory_.emplace(address);
  else
    udp_.emplace(address, port);
}

}  // namespace rollerrig::realtime
