// tests/core/realtime/rig.hpp - a plant, a port and a clock for the server's loop that need neither a rig nor a network nor time.
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "rollerrig/realtime/server.hpp"

namespace rollerrig::test {

/// Sums its first input; sensors are the sum and the second input.
struct SummingPlant {
  double sum{0.0}, second{0.0};
  std::int64_t steps{0}, last{1'000'000};
  std::size_t outputs() const { return 2; }
  void read(std::span<double> out) const { out[0] = sum, out[1] = second; }
  bool step(std::span<double const> command) {
    sum += command[0], second = command[1];
    return ++steps < last;
  }
};

using Frame = std::vector<unsigned char>;

/// What is sent is kept; what is received was put there, or is made by a controller that hears every frame.
struct WiredPort {
  std::deque<std::pair<Frame, realtime::Peer>> inbox;
  std::vector<Frame> sent;
  std::function<void(WiredPort&, Frame const&)> controller{};

  std::ptrdiff_t receive(std::span<unsigned char> buffer, realtime::Peer& sender) {
    if (inbox.empty()) return -1;
    auto const [frame, from] = std::move(inbox.front());
    inbox.pop_front();
    std::size_t const n = std::min(buffer.size(), frame.size());
    std::copy_n(frame.begin(), n, buffer.begin());
    sender = from;
    return static_cast<std::ptrdiff_t>(n);
  }
  void send(std::span<unsigned char const> frame, realtime::Peer) {
    sent.emplace_back(frame.begin(), frame.end());
    if (controller) controller(*this, sent.back());
  }
  void wait(std::int64_t) {}
};

/// Goes on by itself whenever it is looked at; a sleep is a jump.
struct JumpingClock {
  std::int64_t time{0}, at_a_look{1'000};
  std::int64_t now() { return time += at_a_look; }
  void sleep_until(std::int64_t deadline) { time = deadline > time ? deadline : time; }
};

constexpr std::uint32_t session = 77;
constexpr realtime::Peer us = 5, somebody = 6;

inline std::vector<realtime::Input> two_inputs() {
  return {{0.0, 0.0, -10.0, 10.0, false}, {1.0, 2.0, 0.0, 2.0, true}};
}

inline Frame asking(std::uint32_t part = 0) {
  rr_header header{};
  header.kind = RR_ASK;
  header.answers = part;
  Frame frame(rr_frame_size(0));
  rr_write(&header, nullptr, frame.data(), frame.size());
  return frame;
}

inline Frame command(std::uint32_t sequence, std::uint32_t answers, std::vector<double> const& values,
                     unsigned flags = 0, std::uint32_t of_session = session) {
  rr_header header{};
  header.kind = RR_COMMAND;
  header.flags = static_cast<std::uint16_t>(flags);
  header.session = of_session;
  header.sequence = sequence;
  header.answers = answers;
  header.count = static_cast<std::uint16_t>(values.size());
  Frame frame(rr_frame_size(header.count));
  rr_write(&header, values.data(), frame.data(), frame.size());
  return frame;
}

struct Heard {
  rr_header header{};
  std::vector<double> values = std::vector<double>(8);
};

inline Heard heard(Frame const& frame) {
  Heard h;
  if (rr_read(frame.data(), frame.size(), &h.header, h.values.data(), 8) != RR_OK) h.header.kind = 0;
  h.values.resize(h.header.count);
  return h;
}

}  // namespace rollerrig::test
