/* rollerrig_shm.h - the frames of rollerrig_wire.h through shared memory of one machine. C with the atomics of GCC and Clang.
 *
 * The memory that `rollerrig serve --shm NAME` makes (shm_open, mmap, RR_SHM_SIZE bytes) holds two rings, one per direction:
 *
 *   offset            content
 *   0                 'R' 'R' 'I' 'G' 'S' 'H' 'M' '1'
 *   64                ring of the server's frames (rr_ring)
 *   64 + RR_RING_SIZE ring of the controller's frames
 *
 * A ring has one writer, who never waits: frame n stands in slot n % RR_RING_SLOTS until frame n + RR_RING_SLOTS takes its place.
 * A slot's stamp is 2 n + 1 while frame n is being written and 2 n + 2 when it stands there; a reader that finds the stamp
 * changed after its copy has been overtaken. What a torn copy would still hide, the frame's CRC tells.
 */
#ifndef ROLLERRIG_SHM_H
#define ROLLERRIG_SHM_H

#include "rollerrig_wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { RR_RING_SLOTS = 8, RR_SLOT_BYTES = 4176 };

typedef struct rr_slot {
  uint64_t stamp;
  uint32_t size, unused;
  unsigned char frame[RR_SLOT_BYTES];
} rr_slot;

typedef struct rr_ring {
  uint64_t written; /* frames */
  uint64_t unused[7];
  rr_slot slot[RR_RING_SLOTS];
} rr_ring;

enum { RR_RING_SIZE = sizeof(rr_ring), RR_SHM_SIZE = 64 + 2 * sizeof(rr_ring) };

static inline rr_ring* rr_server_ring(void* memory) { return (rr_ring*)((unsigned char*)memory + 64); }
static inline rr_ring* rr_controller_ring(void* memory) { return rr_server_ring(memory) + 1; }

/* Writes a frame; of the ring's one writer. What is longer than a slot is left out. */
static inline void rr_ring_put(rr_ring* ring, unsigned char const* frame, size_t size) {
  uint64_t const n = __atomic_load_n(&ring->written, __ATOMIC_RELAXED);
  rr_slot* slot = &ring->slot[n % RR_RING_SLOTS];
  if (size > RR_SLOT_BYTES) return;
  __atomic_store_n(&slot->stamp, 2 * n + 1, __ATOMIC_RELAXED);
  __atomic_thread_fence(__ATOMIC_RELEASE);
  slot->size = (uint32_t)size;
  memcpy(slot->frame, frame, size);
  __atomic_store_n(&slot->stamp, 2 * n + 2, __ATOMIC_RELEASE);
  __atomic_store_n(&ring->written, n + 1, __ATOMIC_RELEASE);
}

/* Copies frame *next, or the oldest that is still there, and counts *next on. Returns its bytes, -1: there is none yet. */
static inline long rr_ring_get(rr_ring* ring, uint64_t* next, unsigned char* frame, size_t capacity) {
  for (;;) {
    uint64_t const written = __atomic_load_n(&ring->written, __ATOMIC_ACQUIRE);
    rr_slot* slot;
    size_t size;
    if (*next > written) *next = written; /* whoever wrote it, this cannot be */
    if (*next == written) return -1;
    if (written - *next > RR_RING_SLOTS) *next = written - RR_RING_SLOTS;
    slot = &ring->slot[*next % RR_RING_SLOTS];
    if (__atomic_load_n(&slot->stamp, __ATOMIC_ACQUIRE) == 2 * *next + 2) {
      size = slot->size < capacity ? slot->size : capacity;
      if (size > RR_SLOT_BYTES) size = RR_SLOT_BYTES;
      memcpy(frame, slot->frame, size);
      __atomic_thread_fence(__ATOMIC_ACQUIRE);
      if (__atomic_load_n(&slot->stamp, __ATOMIC_RELAXED) == 2 * (*next)++ + 2) return (long)size;
    } else {
      ++*next; /* overtaken */
    }
  }
}

#ifdef __cplusplus
}
#endif
#endif
