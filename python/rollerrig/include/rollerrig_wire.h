/* rollerrig_wire.h - frames between `rollerrig serve` and a controller, for C99 and C++. Version 1.
 *
 *   frame = header of 32 bytes, `count` numbers of 8 bytes (IEEE 754 double), CRC of 4 bytes; all little-endian
 *
 *   offset type  field     meaning
 *   0      u8[4] magic     'R' 'R' 'I' 'G'
 *   4      u8    version   1
 *   5      u8    kind      RR_COMMAND, RR_SENSORS, RR_ASK, RR_DESCRIPTION
 *   6      u16   flags     RR_REARM in a command; else 0
 *   8      u32   session   of this run of the server; 0 in RR_ASK
 *   12     u32   sequence  of the sender's frames, one more with each, 0 follows 2^32 - 1; RR_DESCRIPTION: number of the part
 *   16     i64   time_ns   simulated time of the sensors [ns]; in a command: of the sensors that it answers
 *   24     u32   answers   command: sequence of the sensors that it answers; sensors: of the last command that was accepted;
 *                          RR_ASK: part of the description that is asked for; RR_DESCRIPTION: number of parts
 *   28     u16   count     of numbers that follow; RR_DESCRIPTION: of bytes that follow
 *   30     u16   state     sensors: RR_WAITING to RR_ENDED; else 0
 *   32     ...   values
 *   end    u32   crc       CRC-32 of IEEE 802.3 (that of zlib) over all bytes before it
 *
 * The header needs no library and allocates nothing. There is no encryption and no authentication: loopback, or a network of
 * your own. Explained with an example in docs/how_to/real_time.md.
 */
#ifndef ROLLERRIG_WIRE_H
#define ROLLERRIG_WIRE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { RR_VERSION = 1, RR_HEADER_SIZE = 32, RR_CRC_SIZE = 4, RR_MOST_VALUES = 512, RR_PART_SIZE = 1024 };
enum { RR_LARGEST_FRAME = RR_HEADER_SIZE + 8 * RR_MOST_VALUES + RR_CRC_SIZE };
enum { RR_COMMAND = 1, RR_SENSORS = 2, RR_ASK = 3, RR_DESCRIPTION = 4 };
enum { RR_REARM = 1 };                                                                  /* flags of a command */
enum { RR_WAITING = 0, RR_RUNNING = 1, RR_RAMPING = 2, RR_SAFE = 3, RR_ENDED = 4 };      /* states of the server */
enum { RR_OK = 0, RR_WRONG_LENGTH = 1, RR_FOREIGN = 2, RR_OTHER_VERSION = 3, RR_CORRUPT = 4 }; /* what rr_read() returns */

typedef struct rr_header {
  uint8_t version, kind;
  uint16_t flags;
  uint32_t session, sequence;
  int64_t time_ns;
  uint32_t answers;
  uint16_t count, state;
} rr_header;

static inline uint32_t rr_crc32(void const* data, size_t size) {
  /* four bits at a time: 16 words of table */
  static uint32_t const table[16] = {0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u,
                                     0x4db26158u, 0x5005713cu, 0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu,
                                     0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu};
  unsigned char const* byte = (unsigned char const*)data;
  uint32_t crc = 0xffffffffu;
  size_t i;
  for (i = 0; i < size; ++i) {
    crc ^= byte[i];
    crc = (crc >> 4) ^ table[crc & 15u];
    crc = (crc >> 4) ^ table[crc & 15u];
  }
  return ~crc;
}

static inline void rr_put(unsigned char* at, uint64_t value, int bytes) {
  int i;
  for (i = 0; i < bytes; ++i) at[i] = (unsigned char)(value >> (8 * i));
}

static inline uint64_t rr_get(unsigned char const* at, int bytes) {
  uint64_t value = 0;
  int i;
  for (i = 0; i < bytes; ++i) value |= (uint64_t)at[i] << (8 * i);
  return value;
}

/* Bytes of a frame with `count` numbers. */
static inline size_t rr_frame_size(unsigned count) {
  return (size_t)RR_HEADER_SIZE + 8u * (size_t)count + (size_t)RR_CRC_SIZE;
}

/* Header before `payload` bytes that stand there already, CRC behind them. Returns the bytes of the frame. */
static inline size_t rr_seal(rr_header const* header, unsigned char* frame, size_t payload) {
  size_t const end = (size_t)RR_HEADER_SIZE + payload;
  frame[0] = 'R';
  frame[1] = 'R';
  frame[2] = 'I';
  frame[3] = 'G';
  frame[4] = RR_VERSION;
  frame[5] = header->kind;
  rr_put(frame + 6, header->flags, 2);
  rr_put(frame + 8, header->session, 4);
  rr_put(frame + 12, header->sequence, 4);
  rr_put(frame + 16, (uint64_t)header->time_ns, 8);
  rr_put(frame + 24, header->answers, 4);
  rr_put(frame + 28, header->count, 2);
  rr_put(frame + 30, header->state, 2);
  rr_put(frame + end, rr_crc32(frame, end), 4);
  return end + RR_CRC_SIZE;
}

/* Writes a frame with header->count numbers. Returns its bytes, 0 where `capacity` does not hold them. */
static inline size_t rr_write(rr_header const* header, double const* values, unsigned char* frame, size_t capacity) {
  unsigned i;
  if (header->count > RR_MOST_VALUES || rr_frame_size(header->count) > capacity) return 0;
  for (i = 0; i < header->count; ++i) {
    uint64_t bits;
    memcpy(&bits, values + i, 8);
    rr_put(frame + RR_HEADER_SIZE + 8 * i, bits, 8);
  }
  return rr_seal(header, frame, 8u * (size_t)header->count);
}

/* Reads any frame but its payload, after checking length, origin, version and CRC; returns RR_OK or the first that fails. */
static inline int rr_open(unsigned char const* frame, size_t size, rr_header* header) {
  size_t payload;
  if (size < (size_t)(RR_HEADER_SIZE + RR_CRC_SIZE)) return RR_WRONG_LENGTH;
  if (frame[0] != 'R' || frame[1] != 'R' || frame[2] != 'I' || frame[3] != 'G') return RR_FOREIGN;
  if (frame[4] != RR_VERSION) return RR_OTHER_VERSION;
  if (rr_get(frame + size - RR_CRC_SIZE, 4) != rr_crc32(frame, size - RR_CRC_SIZE)) return RR_CORRUPT;
  header->version = frame[4];
  header->kind = frame[5];
  header->flags = (uint16_t)rr_get(frame + 6, 2);
  header->session = (uint32_t)rr_get(frame + 8, 4);
  header->sequence = (uint32_t)rr_get(frame + 12, 4);
  header->time_ns = (int64_t)rr_get(frame + 16, 8);
  header->answers = (uint32_t)rr_get(frame + 24, 4);
  header->count = (uint16_t)rr_get(frame + 28, 2);
  header->state = (uint16_t)rr_get(frame + 30, 2);
  payload = header->kind == RR_DESCRIPTION ? (size_t)header->count : 8u * (size_t)header->count;
  return size == (size_t)RR_HEADER_SIZE + payload + (size_t)RR_CRC_SIZE ? RR_OK : RR_WRONG_LENGTH;
}

/* Reads a frame of numbers; `values` has room for `capacity` of them. */
static inline int rr_read(unsigned char const* frame, size_t size, rr_header* header, double* values, unsigned capacity) {
  unsigned i;
  int const outcome = rr_open(frame, size, header);
  if (outcome != RR_OK) return outcome;
  if (header->kind == RR_DESCRIPTION || header->count > capacity) return RR_WRONG_LENGTH;
  for (i = 0; i < header->count; ++i) {
    uint64_t const bits = rr_get(frame + RR_HEADER_SIZE + 8 * i, 8);
    memcpy(values + i, &bits, 8);
  }
  return RR_OK;
}

#ifdef __cplusplus
}
#endif
#endif
