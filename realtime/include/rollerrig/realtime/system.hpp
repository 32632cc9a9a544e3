// realtime/system.hpp - what the operating system gives to a loop in real time: datagrams, shared memory, a clock, a place in the queue.
//
// Written for Linux. Elsewhere everything is there by name, and says on its making that it is not.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "rollerrig/realtime/command_gate.hpp"

namespace rollerrig::realtime {

/// Throws std::runtime_error, with what is missing, where this system has none of it.
void require_real_time();

/// Datagrams of IPv4, never waiting to receive; a sender is its address and port.
class UdpPort {
 public:
  /// Throws std::invalid_argument for what is no address of IPv4, std::system_error where it cannot be taken.
  ///
  /// @param address  dotted, of a network of this machine
  /// @param port     0: any that is free
  UdpPort(std::string const& address, int port);
  ~UdpPort();
  UdpPort(UdpPort const&) = delete;
  UdpPort& operator=(UdpPort const&) = delete;

  int port() const { return port_; }
  /// Bytes of the datagram, cut at the buffer's end; -1: none is there.
  std::ptrdiff_t receive(std::span<unsigned char> buffer, Peer& sender);
  void send(std::span<unsigned char const> frame, Peer to);
  /// Until something is there, at most so long [ns].
  void wait(std::int64_t ns);

 private:
  int socket_{-1}, port_{0};
};

/// Two rings of frames in shared memory of this machine, rollerrig_shm.h; whoever writes there is the one controller.
class SharedMemoryPort {
 public:
  /// Makes the memory; throws std::system_error where there is one of that name.
  ///
  /// @param name  begins with '/', and has no other
  explicit SharedMemoryPort(std::string const& name);
  ~SharedMemoryPort();
  SharedMemoryPort(SharedMemoryPort const&) = delete;
  SharedMemoryPort& operator=(SharedMemoryPort const&) = delete;

  std::ptrdiff_t receive(std::span<unsigned char> buffer, Peer& sender);
  void send(std::span<unsigned char const> frame, Peer to);
  void wait(std::int64_t ns);

 private:
  std::string name_;
  void* memory_{nullptr};
  std::uint64_t next_{0};
};

/// One of both, by its address: "/name" is shared memory, everything else of IPv4.
class AnyPort {
 public:
  AnyPort(std::string const& address, int port);

  int port() const { return udp_ ? udp_->port() : 0; }
  std::ptrdiff_t receive(std::span<unsigned char> buffer, Peer& sender) {
    return udp_ ? udp_->receive(buffer, sender) : memory_->receive(buffer, sender);
  }
  void send(std::span<unsigned char const> frame, Peer to) { udp_ ? udp_->send(frame, to) : memory_->send(frame, to); }
  void wait(std::int64_t ns) { udp_ ? udp_->wait(ns) : memory_->wait(ns); }

 private:
  std::optional<UdpPort> udp_;
  std::optional<SharedMemoryPort> memory_;
};

/// Monotonic time, and a sleep to a deadline that ends in a short spin.
class DeadlineClock {
 public:
  explicit DeadlineClock(std::int64_t spin = 50'000) : spin_{spin} {}
  std::int64_t now() const;
  void sleep_until(std::int64_t deadline) const;

 private:
  std::int64_t spin_;  ///< before a deadline [ns]
};

/// Processor time of this thread [ns].
std::int64_t processor_time();

/// This thread ahead of all ordinary ones, with the memory of the program kept from being paged out, until the object is
/// gone; what is not allowed is told and done without.
class RealTimePriority {
 public:
  RealTimePriority();
  ~RealTimePriority();
  RealTimePriority(RealTimePriority const&) = delete;
  RealTimePriority& operator=(RealTimePriority const&) = delete;

  std::string const& memory() const { return memory_; }          ///< "locked", or why it is not
  std::string const& scheduling() const { return scheduling_; }  ///< "SCHED_FIFO", or why not

 private:
  bool locked_{false}, first_{false};
  int policy_before_{0};
  std::string memory_, scheduling_;
};

}  // namespace rollerrig::realtime
