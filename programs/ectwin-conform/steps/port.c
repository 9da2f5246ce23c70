/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "steps/port.h"

#include <errno.h>
#include <net/if.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "ethercat.h"

#include "steps/record.h"
#include "wire/bytes.h"

enum {
    ETHERNET = 14,
    DATAGRAM_HEADER = 10,
    WKC = 2,
    TYPE_DATAGRAMS = 0x1000,
    MORE = 0x8000,
    LOCALLY_ADMINISTERED = 0x02
};
enum {
    SOEM_IMAGE = 65536,
    SOEM_STATE_US = 3000000,
    SOEM_CYCLES = 5000,
    SOEM_CYCLE_US = 500,
    SOEM_TRIES = 3,
    SOEM_REST_US = 200000
};

volatile sig_atomic_t cf_interrupted;

struct cf_port {
    ecx_portt port;
    char iface[IF_NAMESIZE];
    ecx_contextt context;
    ec_slavet slaves[EC_MAXSLAVE];
    int slave_count;
    ec_groupt groups[EC_MAXGROUP];
    uint8 sii_buffer[EC_MAXEEPBUF];
    uint32 sii_map[EC_MAXEEPBITMAP];
    ec_eringt errors;
    ec_idxstackT index_stack;
    boolean error;
    int64 dc_time;
    uint8 image[SOEM_IMAGE];
    ec_SMcommtypet sm_types[EC_MAX_MAPT];
    ec_PDOassignt assignments[EC_MAX_MAPT];
    ec_PDOdesct descriptions[EC_MAX_MAPT];
    ec_eepromSMt sii_sm;
    ec_eepromFMMUt sii_fmmu;
};

/* SOEM's source address is a multicast address, which no station may have. The first ESC sets the "locally
 * administered" bit of the source address to mark returning frames, so the address is sent without this bit. */
static void use_own_address(int socket, const char *iface)
{
    struct ifreq request = {0};
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", iface);
    if (ioctl(socket, SIOCGIFHWADDR, &request) != 0)
        return;
    request.ifr_hwaddr.sa_data[0] &= ~LOCALLY_ADMINISTERED;
    cf_record_source((const uint8_t *)request.ifr_hwaddr.sa_data);
}

const char *cf_port_open(cf_port_t **port, const char *iface)
{
    if (strlen(iface) >= IF_NAMESIZE || if_nametoindex(iface) == 0)
        return "there is no network interface of that name: 'ip -br link' lists all interfaces";
    int probe = socket(PF_PACKET, SOCK_RAW, 0); /* SOEM gives no reason */
    if (probe < 0)
        return errno == EPERM || errno == EACCES
                   ? "it needs the capability CAP_NET_RAW: run it with sudo, or inside 'ectwin with'"
                   : strerror(errno);
    *port = calloc(1, sizeof **port);
    if (*port) {
        snprintf((*port)->iface, sizeof(*port)->iface, "%s", iface);
        use_own_address(probe, iface);
    }
    close(probe);
    if (!*port)
        return strerror(ENOMEM);
    if (ecx_setupnic(&(*port)->port, iface, FALSE) > 0)
        return NULL;
    cf_port_close(*port);
    *port = NULL;
    return "SOEM cannot open it: is it an Ethernet interface that is up?";
}

void cf_port_close(cf_port_t *port)
{
    if (port)
        ecx_closenic(&port->port);
    free(port);
}

const char *cf_port_link(cf_port_t *port, bool up)
{
    struct ifreq request = {0};
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", port->iface);
    if (ioctl(port->port.sockhandle, SIOCGIFFLAGS, &request) != 0)
        return strerror(errno);
    request.ifr_flags = (short)(up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
    if (ioctl(port->port.sockhandle, SIOCSIFFLAGS, &request) != 0)
        return errno == EPERM ? "it needs the capability CAP_NET_ADMIN to take the interface down" : strerror(errno);
    return NULL;
}

static ecx_contextt *soem_context(cf_port_t *p)
{
    p->context = (ecx_contextt){
        .port = &p->port,
        .slavelist = p->slaves,
        .slavecount = &p->slave_count,
        .maxslave = EC_MAXSLAVE,
        .grouplist = p->groups,
        .maxgroup = EC_MAXGROUP,
        .esibuf = p->sii_buffer,
        .esimap = p->sii_map,
        .elist = &p->errors,
        .idxstack = &p->index_stack,
        .ecaterror = &p->error,
        .DCtime = &p->dc_time,
        .SMcommtype = p->sm_types,
        .PDOassign = p->assignments,
        .PDOdesc = p->descriptions,
        .eepSM = &p->sii_sm,
        .eepFMMU = &p->sii_fmmu,
        .manualstatechange = 1,
    };
    return &p->context;
}

/* --- exchange of a frame ------------------------------------------------------------------------------------------ */

static void build(uint8_t *frame, uint8_t index, const cf_datagram_t *d, size_t count, size_t *length)
{
    uint8_t *at = frame + ETHERNET + 2;
    for (size_t i = 0; i < count; i++) {
        at[0] = d[i].command;
        at[1] = index;
        ect_store_le32(at + 2, d[i].address);
        ect_store_le16(at + 6, (uint16_t)(d[i].length | (i + 1 < count ? MORE : 0)));
        ect_store_le16(at + 8, 0);
        if (d[i].data)
            memcpy(at + DATAGRAM_HEADER, d[i].data, d[i].length);
        else
            memset(at + DATAGRAM_HEADER, 0, d[i].length);
        ect_store_le16(at + DATAGRAM_HEADER + d[i].length, d[i].wkc);
        at += DATAGRAM_HEADER + d[i].length + WKC;
    }
    *length = (size_t)(at - frame);
    ect_store_le16(frame + ETHERNET, (uint16_t)(TYPE_DATAGRAMS | (*length - ETHERNET - 2)));
}

/* A late reply to an older frame may have the same index; commands, addresses and lengths differ. */
static bool is_reply(const uint8_t *payload, const cf_datagram_t *d, size_t count)
{
    const uint8_t *at = payload + 2;
    for (size_t i = 0; i < count; i++) {
        if (at[0] != d[i].command || (ect_load_le16(at + 6) & 0x07FF) != d[i].length ||
            ect_load_le16(at + 4) != d[i].address >> 16)
            return false;
        at += DATAGRAM_HEADER + d[i].length + WKC;
    }
    return true;
}

static void take(const uint8_t *payload, cf_datagram_t *d, size_t count)
{
    const uint8_t *at = payload + 2;
    for (size_t i = 0; i < count; i++) {
        d[i].address = ect_load_le32(at + 2);
        d[i].irq = ect_load_le16(at + 8);
        if (d[i].data)
            memcpy(d[i].data, at + DATAGRAM_HEADER, d[i].length);
        d[i].wkc = ect_load_le16(at + DATAGRAM_HEADER + d[i].length);
        at += DATAGRAM_HEADER + d[i].length + WKC;
    }
}

/* @return whether a frame can be received before the deadline */
static bool readable(const ecx_portt *port, uint64_t deadline_ns)
{
    uint64_t now = cf_now_ns();
    struct pollfd fd = {.fd = port->sockhandle, .events = POLLIN};
    int ms = now >= deadline_ns ? 0 : (int)((deadline_ns - now + 999999) / 1000000);
    return poll(&fd, 1, ms) > 0;
}

static bool receive(ecx_portt *port, uint8 index, const cf_datagram_t *d, size_t count, uint64_t deadline_ns)
{
    while (readable(port, deadline_ns) || cf_now_ns() < deadline_ns) {
        if (ecx_waitinframe(port, index, 0) > EC_NOFRAME) {
            if (is_reply(port->rxbuf[index], d, count))
                return true;
            ecx_setbufstat(port, index, EC_BUF_TX);
        }
        if (cf_interrupted > 1)
            return false;
    }
    return false;
}

bool cf_port_exchange(cf_port_t *holder, cf_datagram_t *d, size_t count, uint32_t timeout_ms)
{
    ecx_portt *port = &holder->port;
    uint8 index = ecx_getindex(port);
    size_t length;
    build(port->txbuf[index], index, d, count, &length);
    port->txbuflength[index] = (int)length;
    ecx_outframe(port, index, 0);
    bool came = receive(port, index, d, count, cf_now_ns() + timeout_ms * UINT64_C(1000000));
    if (came)
        take(port->rxbuf[index], d, count);
    ecx_setbufstat(port, index, EC_BUF_EMPTY);
    return came;
}

/* --- raw frames --------------------------------------------------------------------------------------------------- */

/* Compares EtherType, header and datagram address, which no slave changes in a NOP. */
static bool is_marker(const uint8_t *got, ssize_t length, const uint8_t *marker, size_t marker_length)
{
    return length >= (ssize_t)marker_length && memcmp(got + 12, marker + 12, 2 + 2 + 6) == 0;
}

ssize_t cf_port_raw(cf_port_t *port, const void *frame, size_t length, uint8_t *reply, size_t room, uint32_t timeout_ms)
{
    ecx_portt *wire = &port->port;
    uint8_t marker[60] = {0}, got[2048];
    size_t marker_length;
    ssize_t replied = 0;
    const cf_datagram_t mark = {.command = EC_CMD_NOP, .address = 0x5AA5C33C, .length = 4};
    ec_setupheader(marker);
    build(marker, 0xFE, &mark, 1, &marker_length);
    (void)send(wire->sockhandle, frame, length, 0);
    (void)send(wire->sockhandle, marker, sizeof marker, 0);
    uint64_t deadline_ns = cf_now_ns() + timeout_ms * UINT64_C(1000000);
    while (readable(wire, deadline_ns)) {
        ssize_t size = recv(wire->sockhandle, got, sizeof got, 0);
        if (size <= 0)
            continue;
        if (is_marker(got, size, marker, marker_length))
            return replied;
        replied = size;
        if (reply)
            memcpy(reply, got, (size_t)size < room ? (size_t)size : room);
    }
    return -1;
}

/* --- SOEM's start-up ---------------------------------------------------------------------------------------------- */

static bool soem_reached(ecx_contextt *soem, uint16_t slave, uint16_t state, char *what, size_t room)
{
    if (ecx_statecheck(soem, slave, state, SOEM_STATE_US) == state)
        return true;
    ecx_readstate(soem);
    snprintf(what, room, "expected state %u, got 0x%02X with code 0x%04X", state, soem->slavelist[slave].state,
             soem->slavelist[slave].ALstatuscode);
    return false;
}

static bool soem_operational(ecx_contextt *soem, uint16_t slave, char *what, size_t room)
{
    ecx_send_processdata(soem);
    (void)ecx_receive_processdata(soem, EC_TIMEOUTRET);
    soem->slavelist[slave].state = EC_STATE_OPERATIONAL;
    ecx_writestate(soem, slave);
    for (int i = 0; i < SOEM_CYCLES && cf_interrupted == 0; i++) {
        ecx_send_processdata(soem);
        (void)ecx_receive_processdata(soem, EC_TIMEOUTRET);
        if (ecx_statecheck(soem, slave, EC_STATE_OPERATIONAL, SOEM_CYCLE_US) == EC_STATE_OPERATIONAL)
            return true;
    }
    return soem_reached(soem, slave, EC_STATE_OPERATIONAL, what, room);
}

static bool soem_to_preop(ecx_contextt *soem, uint16_t slave, char *what, size_t room)
{
    int found = 0;
    /* SOEM takes a reply that is 16 requests late for that of the present one: behind a busy PC it begins again */
    for (int i = 0; i < SOEM_TRIES && found < slave && cf_interrupted == 0; i++) {
        if (i > 0)
            osal_usleep(SOEM_REST_US);
        found = ecx_config_init(soem, FALSE);
    }
    if (found < slave) {
        snprintf(what, room, "expected at least %u slaves, got %d", slave, found);
        return false;
    }
    soem->slavelist[slave].state = EC_STATE_PRE_OP | EC_STATE_ACK;
    ecx_writestate(soem, slave);
    return soem_reached(soem, slave, EC_STATE_PRE_OP, what, room);
}

bool cf_port_soem_to_op(cf_port_t *port, uint16_t slave, char *what, size_t room)
{
    ecx_contextt *soem = soem_context(port);
    if (!soem_to_preop(soem, slave, what, room))
        return false;
    (void)ecx_config_map_group(soem, port->image, 0);
    soem->slavelist[slave].state = EC_STATE_SAFE_OP | EC_STATE_ACK;
    ecx_writestate(soem, slave);
    return soem_reached(soem, slave, EC_STATE_SAFE_OP, what, room) && soem_operational(soem, slave, what, room);
}

bool cf_port_soem_address(cf_port_t *port, uint16_t slave, const uint8_t set[4], uint8_t got[4], char *what,
                          size_t room)
{
    ecx_contextt *soem = soem_context(port);
    eoe_param_t address = {.ip_set = 1, .subnet_set = 1, .default_gateway_set = 1}, now = {.ip_set = 0};
    if (!soem_to_preop(soem, slave, what, room))
        return false;
    EOE_IP4_ADDR_TO_U32(&address.ip, set[0], set[1], set[2], set[3]);
    EOE_IP4_ADDR_TO_U32(&address.subnet, 255, 255, 255, 0);
    EOE_IP4_ADDR_TO_U32(&address.default_gateway, set[0], set[1], set[2], 1);
    int result = ecx_EOEsetIp(soem, slave, 0, &address, EC_TIMEOUTRXM);
    if (result <= 0) {
        snprintf(what, room, "expected ecx_EOEsetIp to succeed, got %d", result);
        return false;
    }
    result = ecx_EOEgetIp(soem, slave, 0, &now, EC_TIMEOUTRXM);
    if (result <= 0) {
        snprintf(what, room, "expected ecx_EOEgetIp to succeed, got %d", result);
        return false;
    }
    const uint8_t octets[] = {eoe_ip4_addr1(&now.ip), eoe_ip4_addr2(&now.ip), eoe_ip4_addr3(&now.ip),
                              eoe_ip4_addr4(&now.ip)};
    memcpy(got, octets, sizeof octets);
    return true;
}
