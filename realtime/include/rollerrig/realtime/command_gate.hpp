// realtime/command_gate.hpp - which of the frames that arrive are acted on.
//
//   bytes, sender -> [gate] -> a command, or the reason why it is dropped; each counted
//
// A frame passes in this order: length, origin, version, CRC (rollerrig_wire.h); session, sender; kind and number of values;
// its sequence is new; it answers sensors that are neither to come nor too old; every value is allowed. The first that fails
// names the drop. The gate keeps the one controller that may command: the first that asked, until it has been given up.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "rollerrig/realtime/histogram.hpp"
#include "rollerrig/realtime/watchdog.hpp"
#include "rollerrig_wire.h"

namespace rollerrig::realtime {

using Peer = std::uint64_t;  ///< an address and port, or what else a port tells senders apart by; 0: nobody

enum class Verdict : int {
  accepted,
  asked,    ///< for the description
  refused,  ///< asked, but another controller has the rig
  wrong_length,
  foreign,
  other_version,
  corrupt,
  repeated,
  reordered,
  late,
  not_allowed,
};

inline constexpr std::string_view verdict_names[] = {"accepted",  "asked",         "refused",    "wrong_length",
                                                     "foreign",   "other_version", "corrupt",    "repeated",
                                                     "reordered", "late",          "not_allowed"};
constexpr std::size_t verdict_count = std::size(verdict_names);

class CommandGate {
 public:
  /// @param oldest  periods that the sensors may be old that a command answers
  CommandGate(std::vector<Input> inputs, std::uint32_t session, std::uint32_t oldest)
      : inputs_{std::move(inputs)},
        command_(inputs_.size()),
        read_(inputs_.size()),
        session_{session},
        oldest_{oldest} {}

  /// @param sent  sequence of the last sensors that were sent
  Verdict judge(std::span<unsigned char const> frame, Peer sender, std::uint32_t sent) {
    Verdict const verdict = look(frame, sender, sent);
    counted_[static_cast<std::size_t>(verdict)].add();
    return verdict;
  }

  /// Of the last frame that was accepted, asked or was refused.
  rr_header const& header() const { return header_; }
  std::span<double const> command() const { return command_; }
  Peer peer() const { return peer_; }
  std::uint32_t last_sequence() const { return last_; }
  std::uint64_t counted(Verdict v) const { return counted_[static_cast<std::size_t>(v)].get(); }
  /// Whoever asks next may command.
  void give_up_peer() { given_up_ = true; }

 private:
  Verdict look(std::span<unsigned char const> frame, Peer sender, std::uint32_t sent) {
    rr_header header;
    int const opened = rr_open(frame.data(), frame.size(), &header);
    if (opened != RR_OK) return static_cast<Verdict>(opened + static_cast<int>(Verdict::refused));
    if (header.kind == RR_ASK) return look_at_asking(header, sender);
    if (header.session != session_ || sender != peer_) return Verdict::foreign;
    if (header.kind != RR_COMMAND) return Verdict::not_allowed;
    if (header.count != inputs_.size()) return Verdict::wrong_length;
    auto const ahead = static_cast<std::int32_t>(header.sequence - last_);  // sequences go round
    if (known_ && ahead == 0) return Verdict::repeated;
    if (known_ && ahead < 0) return Verdict::reordered;
    auto const age = static_cast<std::int32_t>(sent - header.answers);
    if (age < 0) return Verdict::not_allowed;
    if (static_cast<std::uint32_t>(age) > oldest_) return Verdict::late;
    if (rr_read(frame.data(), frame.size(), &header, read_.data(), static_cast<unsigned>(read_.size())) != RR_OK)
      return Verdict::not_allowed;
    for (std::size_t i = 0; i < read_.size(); ++i)
      if (!inputs_[i].allows(read_[i])) return Verdict::not_allowed;  // so are NaN and infinities
    last_ = header.sequence, known_ = true, given_up_ = false;
    header_ = header;
    command_ = read_;
    return Verdict::accepted;
  }

  Verdict look_at_asking(rr_header const& header, Peer sender) {
    if (header.count != 0) return Verdict::wrong_length;
    header_ = header;
    if (sender != peer_) {
      if (!given_up_) return Verdict::refused;
      peer_ = sender, known_ = false;
    }
    given_up_ = false;
    return Verdict::asked;
  }

  std::vector<Input> inputs_;
  std::vector<double> command_, read_;
  std::uint32_t session_, oldest_;
  rr_header header_{};
  Peer peer_{0};
  std::uint32_t last_{0};
  bool known_{false}, given_up_{true};
  std::array<Counter, verdict_count> counted_{};
};

}  // namespace rollerrig::realtime
