/* SPDX-License-Identifier: MIT */
#include "bus/net/endless.h"

#include "wire/bytes.h"

enum { SOURCE = 6, TYPE = 12, TAG = 4, IP_AND_UDP = 28, DATAGRAM = 16, DATA = DATAGRAM + 10 };
enum { ETHERTYPE_VLAN = 0x8100, ETHERTYPE_ECAT = 0x88A4, ETHERTYPE_IPV4 = 0x0800 };

typedef struct ect_endless_mark mark_t;

/* @return false: the frame contains no datagram */
static bool mark_of(const uint8_t *frame, size_t length, mark_t *mark)
{
    uint8_t source = length > SOURCE ? frame[SOURCE] : 0;
    if (length >= DATA + TAG && ect_load_be16(frame + TYPE) == ETHERTYPE_VLAN) {
        frame += TAG;
        length -= TAG;
    }
    if (length < DATA)
        return false;
    uint16_t type = ect_load_be16(frame + TYPE);
    if (type == ETHERTYPE_IPV4 && length >= DATA + IP_AND_UDP) { /* of a UDP port */
        frame += IP_AND_UDP;
        length -= IP_AND_UDP;
    } else if (type != ETHERTYPE_ECAT) {
        return false;
    }
    uint16_t size = ect_load_le16(frame + DATAGRAM + 6) & 0x07FF;
    if (length < (size_t)DATA + size + 2)
        return false;
    *mark = (mark_t){
        .datagram = 1ull << 63 | (uint64_t)size << 32 | (uint64_t)ect_load_le16(frame + DATAGRAM + 4) << 16 |
                    ect_load_le16(frame + DATAGRAM),
        .position = ect_load_le16(frame + DATAGRAM + 2),
        .working_counter = ect_load_le16(frame + DATA + size),
        .source = source,
    };
    return true;
}

/* The position wraps, so half of its range counts as "not smaller". */
static bool begins_where(const mark_t *came, const mark_t *sent)
{
    return came->datagram == sent->datagram && (uint16_t)(came->position - sent->position) < 0x8000 &&
           came->working_counter >= sent->working_counter && came->source == sent->source;
}

void ect_endless_sent(ect_endless_t *endless, const uint8_t *frame, size_t length)
{
    mark_t mark;
    if (!mark_of(frame, length, &mark))
        return;
    endless->sent[endless->next] = mark;
    endless->next = (endless->next + 1) % ECT_ENDLESS_REMEMBERED;
}

bool ect_endless_received(ect_endless_t *endless, const uint8_t *frame, size_t length, uint64_t now_ns)
{
    mark_t mark;
    if (!mark_of(frame, length, &mark))
        return false;
    bool ours = false;
    for (unsigned int i = 0; i < ECT_ENDLESS_REMEMBERED && !ours; i++)
        ours = begins_where(&mark, &endless->sent[i]);
    if (!ours)
        return false;
    if (now_ns - endless->window_ns >= ECT_ENDLESS_WINDOW_NS) {
        endless->window_ns = now_ns;
        endless->seen = 0;
    }
    endless->seen++;
    return endless->seen > ECT_ENDLESS_MOST;
}
