/* SPDX-License-Identifier: MIT */
/* The processing unit: the datagrams of a frame, in order, changed in place (data sheet I §2, ETG.1000.4 §5). */
#include <string.h>

#include "esc/internal.h"
#include "esc/route.h"

enum {
    ETHERTYPE_ECAT = 0x88A4,
    ETHERTYPE_VLAN = 0x8100,
    ETHERTYPE_IPV4 = 0x0800,
    UDP_PORT_ECAT = 0x88A4,
    ETHERNET_HEADER = 14,
    IP_AND_UDP = 28,
    TYPE_DATAGRAMS = 1,
    CIRCULATING = 0x40, /* bit 14 of the length */
};

static bool station_matches(const ect_esc_t *esc, uint16_t address)
{
    return address == ect_load_le16(esc->memory + ECT_REG_STATION_ADDRESS) || address == ect_esc_second_station(esc);
}

/* Commands form groups of three: read, write, both. */
static unsigned int in_its_group(unsigned int offset)
{
    static const uint8_t parts[] = {ECT_PART_READ, ECT_PART_WRITE, ECT_PART_READ | ECT_PART_WRITE};
    return parts[offset];
}

/* The parts of this slave in a datagram: ECT_PART_... */
static unsigned int decide(const ect_esc_t *esc, const uint8_t *d)
{
    uint8_t command = d[ECT_DATAGRAM_COMMAND];
    uint16_t adp = ect_load_le16(d + ECT_DATAGRAM_ADP);
    switch (command) {
    case ECT_APRD:
    case ECT_APWR:
    case ECT_APRW:
        return adp == 0 ? in_its_group(command - (unsigned int)ECT_APRD) : 0;
    case ECT_FPRD:
    case ECT_FPWR:
    case ECT_FPRW:
        return station_matches(esc, adp) ? in_its_group(command - (unsigned int)ECT_FPRD) : 0;
    case ECT_BRD:
    case ECT_BWR:
    case ECT_BRW:
        return in_its_group(command - (unsigned int)ECT_BRD) | ECT_PART_OR;
    case ECT_ARMW:
        return adp == 0 ? ECT_PART_READ : ECT_PART_WRITE;
    case ECT_FRMW:
        return station_matches(esc, adp) ? ECT_PART_READ : ECT_PART_WRITE;
    default:
        return 0;
    }
}

static void or_into(uint8_t *to, const uint8_t *from, uint16_t length)
{
    for (uint16_t i = 0; i < length; i++)
        to[i] |= from[i];
}

static bool read_physical(ect_esc_t *esc, uint8_t *to, uint16_t address, uint16_t length)
{
    ECT_ASSERT(length > 0);
    ect_access_t access = {.side = ECT_SIDE_ECAT, .write = false, .data = to};
    return ect_esc_access(esc, &access, address, length);
}

static bool write_physical(ect_esc_t *esc, uint8_t *from, uint16_t address, uint16_t length, bool latches)
{
    ECT_ASSERT(length > 0);
    ect_access_t access = {.side = ECT_SIDE_ECAT, .write = true, .latches = latches, .data = from};
    return ect_esc_access(esc, &access, address, length);
}

/* Reads and writes at once: the data of the frame are written after the previous data have been read. */
static unsigned int exchange_physical(ect_esc_t *esc, uint8_t *data, uint16_t address, uint16_t length, bool or_read)
{
    uint8_t *scratch = esc->scratch;
    ECT_ASSERT(length > 0 && length <= ECT_ESC_MAX_FRAME);
    uint16_t write_address = (uint16_t)(address + ect_load_le16(esc->memory + ECT_REG_RW_OFFSET));
    if (or_read)
        memset(scratch, 0, length);
    else
        memcpy(scratch, data, length);
    unsigned int gain = read_physical(esc, or_read ? scratch : data, address, length) ? 1 : 0;
    gain += write_physical(esc, or_read ? data : scratch, write_address, length, false) ? 2 : 0;
    if (or_read)
        or_into(data, scratch, length);
    return gain;
}

/* Only these writes latch the receive times (data sheet I §9.1.2). */
static bool latches(const uint8_t *d)
{
    return d[ECT_DATAGRAM_COMMAND] == ECT_BWR || d[ECT_DATAGRAM_COMMAND] == ECT_FPWR;
}

/* Physical addressing. @return increment of the working counter */
static unsigned int access_physical(ect_esc_t *esc, uint8_t *d, unsigned int part)
{
    uint8_t *data = d + ECT_DATAGRAM_DATA;
    uint8_t *scratch = esc->scratch;
    uint16_t length = ect_datagram_length(d);
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADO);
    bool or_read = (part & ECT_PART_OR) != 0;
    if ((part & ECT_PART_WRITE) != 0 && (part & ECT_PART_READ) != 0)
        return exchange_physical(esc, data, address, length, or_read);
    if ((part & ECT_PART_WRITE) != 0)
        return write_physical(esc, data, address, length, latches(d)) ? 1 : 0;
    if (!or_read)
        return read_physical(esc, data, address, length) ? 1 : 0;
    memset(scratch, 0, length);
    bool any = read_physical(esc, scratch, address, length);
    or_into(data, scratch, length);
    return any ? 1 : 0;
}

/* @param unread  0, or ECT_PART_UNREAD */
static unsigned int access_logical(ect_esc_t *esc, uint8_t *d, unsigned int unread)
{
    uint8_t command = d[ECT_DATAGRAM_COMMAND];
    uint32_t logical = ect_load_le32(d + ECT_DATAGRAM_ADP);
    uint16_t length = ect_datagram_length(d);
    uint8_t *data = d + ECT_DATAGRAM_DATA;
    unsigned int part = ect_command_direction(command) | unread;
    unsigned int done = esc->fmmus_plain ? ect_esc_fmmu_bytes(esc, logical, data, length, part)
                                         : ect_esc_fmmu_bits(esc, logical, data, length, part);
    if (command == ECT_LRW)
        return done; /* ECT_PART_READ: +1 for the read, ECT_PART_WRITE: +2 for the write */
    return done != 0 ? 1 : 0;
}

static unsigned int execute(ect_esc_t *esc, uint8_t *d, unsigned int part)
{
    const unsigned int both = ECT_PART_READ | ECT_PART_WRITE;
    uint16_t features = esc->config.personality->features;
    ECT_ASSERT(ect_datagram_length(d) <= ECT_ESC_MAX_FRAME);
    if (ect_datagram_length(d) == 0)
        return 0;
    if (ect_command_direction(d[ECT_DATAGRAM_COMMAND]) != 0) {
        bool refused = d[ECT_DATAGRAM_COMMAND] == ECT_LRW && (features & ECT_FEATURE_NO_LRW) != 0;
        return refused ? 0 : access_logical(esc, d, part & ECT_PART_UNREAD);
    }
    bool refused = (part & both) == both && (features & ECT_FEATURE_NO_RW) != 0;
    return part == 0 || refused ? 0 : access_physical(esc, d, part);
}

void ect_esc_begin_of_frame(ect_esc_t *esc, uint64_t now_ns)
{
    ect_esc_advance(esc, now_ns);
}

unsigned int ect_esc_datagram(ect_esc_t *esc, uint8_t *datagram, unsigned int part)
{
    return execute(esc, datagram, part);
}

void ect_esc_take_time(ect_esc_t *esc, uint32_t time, uint64_t now_ns)
{
    ect_esc_advance(esc, now_ns);
    ect_esc_dc_take(esc, time);
}

void ect_esc_postpone_time(ect_esc_t *esc, uint32_t time)
{
    uint8_t data[4];
    ect_store_le32(data, time);
    (void)write_physical(esc, data, ECT_REG_DC_SYSTEM_TIME, sizeof data, false);
}

void ect_esc_end_of_frame(ect_esc_t *esc)
{
    if (esc->per_frame == 0)
        return;
    if ((esc->per_frame & ECT_FRAME_COMMITS) != 0)
        ect_esc_commit(esc);
    if ((esc->per_frame & ECT_FRAME_END_SII) != 0)
        ect_esc_sii_end_of_frame(esc);
    if ((esc->per_frame & ECT_FRAME_END_MII) != 0)
        ect_esc_mii_end_of_frame(esc);
    if ((esc->per_frame & ECT_FRAME_BEGINS) != 0) /* a reset sequence may be complete */
        ect_esc_access_ends(esc);
}

static void process_datagram(ect_esc_t *esc, uint8_t *d)
{
    uint8_t *counter = d + ECT_DATAGRAM_DATA + ect_datagram_length(d);
    /* The header passes before the data, so an event that this datagram clears is still in it. */
    ect_store_le16(d + ECT_DATAGRAM_IRQ, (uint16_t)(ect_load_le16(d + ECT_DATAGRAM_IRQ) | ect_esc_shown_events(esc)));
    unsigned int gain = execute(esc, d, decide(esc, d));
    ect_store_le16(counter, (uint16_t)(ect_load_le16(counter) + gain));
    if (ect_command_counts(d[ECT_DATAGRAM_COMMAND]))
        ect_store_le16(d + ECT_DATAGRAM_ADP, (uint16_t)(ect_load_le16(d + ECT_DATAGRAM_ADP) + 1));
}

/* Offset of the EtherCAT header; 0: not an EtherCAT frame. */
static size_t find_header(const uint8_t *frame, size_t length)
{
    ECT_ASSERT(length >= ETHERNET_HEADER);
    size_t at = ETHERNET_HEADER - 2;
    if (ect_load_be16(frame + at) == ETHERTYPE_VLAN)
        at += 4;
    if (length < at + 2)
        return 0;
    uint16_t type = ect_load_be16(frame + at);
    at += 2;
    if (type == ETHERTYPE_ECAT)
        return at;
    const uint8_t *ip = frame + at;
    if (type != ETHERTYPE_IPV4 || length < at + IP_AND_UDP || ip[0] != 0x45 || ip[9] != 0x11 ||
        ect_load_be16(ip + 22) != UDP_PORT_ECAT)
        return 0;
    return at + IP_AND_UDP;
}

/* Whether the datagrams, by their own lengths and "more" bits, fit into the frame. The length in the EtherCAT header
 * is ignored. */
static bool datagrams_fit(const uint8_t *frame, size_t at, size_t length)
{
    for (;;) {
        if (length < at + ECT_DATAGRAM_DATA + ECT_DATAGRAM_COUNTER || length - at < ect_datagram_size(frame + at))
            return false;
        if (!ect_datagram_follows(frame + at))
            return true;
        at += ect_datagram_size(frame + at);
    }
}

size_t ect_frame_datagrams(const uint8_t *frame, size_t length)
{
    if (length > ECT_ESC_MAX_FRAME || length < ETHERNET_HEADER)
        return 0;
    size_t at = find_header(frame, length);
    bool summed = at >= ETHERNET_HEADER + IP_AND_UDP && ect_load_be16(frame + at - 2) != 0;
    bool plain = at != 0 && !summed && datagrams_fit(frame, at + 2, length);
    return plain && ect_load_le16(frame + at) >> 12 == TYPE_DATAGRAMS ? at + 2 : 0;
}

/* @return false: the frame has passed here before and is to be destroyed */
static bool mark_circulating(const ect_esc_t *esc, uint8_t *datagram)
{
    if (!ect_esc_circulates(esc))
        return true;
    for (uint8_t *d = datagram; d; d = ect_datagram_next(d)) {
        if ((d[ECT_DATAGRAM_LENGTH + 1] & CIRCULATING) != 0)
            return false;
        d[ECT_DATAGRAM_LENGTH + 1] |= CIRCULATING;
    }
    return true;
}

static ect_frame_result_t not_ours(ect_esc_t *esc)
{
    if ((esc->memory[ECT_REG_DL_CONTROL] & 0x01) == 0)
        return ECT_FRAME_FORWARD;
    ect_esc_count(esc, ECT_REG_PROCESSING_ERROR);
    return ECT_FRAME_DESTROYED;
}

static ect_frame_result_t invalid(ect_esc_t *esc)
{
    ect_esc_damaged(esc, 0, false);
    return ECT_FRAME_DESTROYED;
}

/* The chip sets the "locally administered" bit of the source address, which identifies a frame on its way back. */
static void mark_source(const ect_esc_t *esc, uint8_t *frame)
{
    if (ect_esc_marks_source(esc))
        frame[6] |= 0x02;
}

ect_frame_result_t ect_esc_pass(ect_esc_t *esc, uint8_t *frame, size_t length, uint64_t now_ns)
{
    ect_esc_advance(esc, now_ns);
    if ((esc->per_frame & ECT_FRAME_BEGINS) != 0)
        ect_esc_protect_begins(esc, ECT_SIDE_ECAT);
    if (length > ECT_ESC_MAX_FRAME || length < ETHERNET_HEADER)
        return invalid(esc);
    size_t at = find_header(frame, length);
    if (at == 0 || (length >= at + 2 && ect_load_le16(frame + at) >> 12 != TYPE_DATAGRAMS))
        return not_ours(esc);
    if (!datagrams_fit(frame, at + 2, length))
        return invalid(esc);
    if (at >= ETHERNET_HEADER + IP_AND_UDP) /* the UDP check sum will not match the data; 0 means that there is none */
        memset(frame + at - 2, 0, 2);
    if (!mark_circulating(esc, frame + at + 2))
        return ECT_FRAME_DESTROYED;
    mark_source(esc, frame);
    for (uint8_t *d = frame + at + 2; d; d = ect_datagram_next(d))
        process_datagram(esc, d);
    return ECT_FRAME_FORWARD;
}

ect_frame_result_t ect_esc_process(ect_esc_t *esc, uint8_t *frame, size_t length, uint64_t now_ns)
{
    ect_frame_result_t result = ect_esc_pass(esc, frame, length, now_ns);
    ect_esc_end_of_frame(esc);
    return result;
}
