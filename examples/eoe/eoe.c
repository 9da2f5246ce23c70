/* SPDX-License-Identifier: MIT */
/*
 * A bridge between a slave with EoE and this computer: frames of a TAP interface are sent to the slave in mails, and
 * frames of the slave to the TAP. A minimal version of the EoE switch of a master's IP stack.
 *
 * Each turn transfers one mail in each direction, fragment by fragment, like IgH: a slave may accept a mail only after
 * its own mail has been fetched, so a master that sends a complete frame without fetching may deadlock. With --sdo, an
 * SDO upload takes turns with the fragments, and the last line reports how many mails of the slave have preceded its
 * reply.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "master.h"

enum { FRAME = 1518, HEADERS = 10, FRAGMENT_HEADER = 4, UNIT = 32, TRIES = 20 };
enum { MAILBOX_FULL = 8, QUIET_US = 200, SDO_PAUSE_NS = 10000000 };
enum { SM1_ACTIVATION = 0x080E, REPEAT = 2, ACCESSES_MOST = 1000 };
enum { SDO_REQUEST = 2, UPLOAD = 0x40, SDO_BYTES = 10 };

typedef struct settings {
    const char *iface;
    const char *tap;
    const char *address; /* address of the slave; NULL: not set */
    unsigned int slave;
    bool sdo;
} settings_t;

/* A frame received in fragments; the first five members are those of SOEM. */
typedef struct incoming {
    uint8 fragment;
    uint16 size, offset, number;
    int length;
    uint8 frame[2048];
} incoming_t;

typedef struct outgoing {
    int length, sent; /* equal: no frame is under way */
    uint8 fragment, number;
    uint8 frame[FRAME];
} outgoing_t;

typedef struct bridge {
    uint16 slave;
    int tap;
    bool sdo;
    incoming_t in;
    outgoing_t out;
    uint64_t to_slave, from_slave, broken, sdos; /* frames, SDO replies */
    uint64_t sdo_due_ns;
    uint8 counter;                  /* counter of the slave's last mail; 0: the slave does not count */
    unsigned int mails, most_mails; /* mails of the slave since the SDO request; 0 to the longest wait */
    bool waits;                     /* for the reply of an SDO request */
    ec_mbxbuft mail;                /* to the slave */
    bool due;                       /* the mail has not yet arrived */
} bridge_t;

/* The next mail to send, after its header. */
static uint8 *prepare(bridge_t *b, uint8 type, int length)
{
    ec_mbxheadert *header = (ec_mbxheadert *)&b->mail;
    ec_clearmbx(&b->mail);
    ec_slave[b->slave].mbx_cnt = ec_nextmbxcnt(ec_slave[b->slave].mbx_cnt);
    header->length = htoes((uint16)length);
    header->mbxtype = (uint8)(type | ec_slave[b->slave].mbx_cnt << 4);
    b->due = true;
    return (uint8 *)&b->mail + sizeof *header;
}

/* Sends the mail, if the slave has taken the previous one. After a lost frame the mail is repeated with the same
 * counter: a slave that has received it ignores the repetition. @return whether the mail has arrived */
static bool send_mail(bridge_t *b)
{
    if (!b->due)
        return false;
    if ((((const ec_mbxheadert *)&b->mail)->mbxtype & 0x0F) == ECT_MBXT_COE)
        b->mails = 0; /* also if the frame seems lost, because the slave may have received the request */
    b->due = ec_mbxsend(b->slave, &b->mail, 0) <= 0;
    return !b->due;
}

/* --- to the slave ------------------------------------------------------------------------------------------------- */

/* Takes the next frame of the TAP. @return whether a frame is under way */
static bool take_frame(bridge_t *b)
{
    outgoing_t *o = &b->out;
    if (o->sent < o->length)
        return true;
    ssize_t length = read(b->tap, o->frame, sizeof o->frame);
    if (length <= 0)
        return false;
    o->length = (int)length;
    o->sent = o->fragment = 0;
    o->number = (o->number + 1) & 0x0F;
    return true;
}

static void prepare_fragment(bridge_t *b)
{
    outgoing_t *o = &b->out;
    const int room = ec_slave[b->slave].mbx_l - HEADERS;
    const int rest = o->length - o->sent;
    const bool last = rest <= room;
    const int bytes = last ? rest : room / UNIT * UNIT;
    const int units = o->sent == 0 ? (o->length + UNIT - 1) / UNIT : o->sent / UNIT;
    (void)prepare(b, ECT_MBXT_EOE, FRAGMENT_HEADER + bytes);
    ec_EOEt *mail = (ec_EOEt *)&b->mail;
    mail->frameinfo1 = htoes((uint16)EOE_HDR_LAST_FRAGMENT_SET(last ? 1 : 0));
    mail->frameinfo2 = htoes(
        (uint16)(EOE_HDR_FRAG_NO_SET(o->fragment) | EOE_HDR_FRAME_OFFSET_SET(units) | EOE_HDR_FRAME_NO_SET(o->number)));
    memcpy(mail->data, o->frame + o->sent, (size_t)bytes);
    o->sent += bytes;
    o->fragment++;
    b->to_slave += last;
}

/* Requests the vendor id, 1018h:01. */
static void prepare_sdo(bridge_t *b)
{
    static const uint8 upload[SDO_BYTES] = {0, SDO_REQUEST << 4, UPLOAD, 0x18, 0x10, 1};
    memcpy(prepare(b, ECT_MBXT_COE, sizeof upload), upload, sizeof upload);
    b->waits = true;
}

/* Sends an SDO before the next fragment. */
static void prepare_next(bridge_t *b)
{
    if (b->due)
        return;
    if (b->sdo && !b->waits && master_now() >= b->sdo_due_ns)
        prepare_sdo(b);
    else if (take_frame(b))
        prepare_fragment(b);
}

/* --- from the slave ----------------------------------------------------------------------------------------------- */

static void take_fragment(bridge_t *b, ec_mbxbuft *mail)
{
    incoming_t *in = &b->in;
    in->length = sizeof in->frame;
    int result = ecx_EOEreadfragment(mail, &in->fragment, &in->size, &in->offset, &in->number, &in->length, in->frame);
    if (result < 0)
        b->broken++;
    if (result <= 0)
        return;
    if (write(b->tap, in->frame, (size_t)in->length) == in->length)
        b->from_slave++;
    else
        b->broken++;
}

/* @return whether the slave has a mail for the master */
static bool mail_waits(const bridge_t *b)
{
    uint16 status = 0;
    int wkc = ec_FPRD(ec_slave[b->slave].configadr, ECT_REG_SM1STAT, sizeof status, &status, EC_TIMEOUTRET);
    return wkc > 0 && (etohs(status) & MAILBOX_FULL) != 0;
}

/* Ignores repeated mails, which have the same counter; SOEM leaves this check to its caller. A slave whose next mail
 * already waits cannot determine which of both mails the master has lost, and repeats the previous one. */
static bool is_repeated(bridge_t *b, const ec_mbxheadert *header)
{
    const uint8 before = b->counter;
    b->counter = header->mbxtype >> 4 & 7;
    return b->counter != 0 && b->counter == before;
}

typedef int access_t(uint16 slave, uint16 address, uint16 length, void *data, int timeout);

/* Accesses a byte of SyncManager 1 until a reply confirms it. */
static bool access_byte(const bridge_t *b, access_t *access, uint16 address, uint8 *value)
{
    int left = ACCESSES_MOST;
    while (left > 0 && !master_ended && access(ec_slave[b->slave].configadr, address, 1, value, EC_TIMEOUTRET) <= 0)
        left--;
    return left > 0 && !master_ended;
}

/* Requests the last mail again, because a frame that contained it was lost. ec_mbxreceive() writes the request, a
 * changed bit, only once: if this frame is lost, so is the mail. @return whether the slave has a mail; false: it
 * repeats none */
static bool request_again(const bridge_t *b)
{
    uint8 request, reply;
    int left = ACCESSES_MOST;
    if (!access_byte(b, ec_FPRD, SM1_ACTIVATION, &request))
        return false;
    request ^= REPEAT;
    if (!access_byte(b, ec_FPWR, SM1_ACTIVATION, &request))
        return false;
    do {
        if (left-- == 0 || !access_byte(b, ec_FPRD, ECT_REG_SM1CONTR, &reply))
            return false;
    } while (((reply ^ request) & REPEAT) != 0);
    while (left > 0 && !mail_waits(b))
        left--;
    return left > 0;
}

/* @return whether a mail of CoE is an emergency, which is no reply */
static bool is_emergency(const ec_mbxbuft *mail)
{
    return (*mail)[sizeof(ec_mbxheadert) + 1] >> 4 == ECT_COES_EMERGENCY;
}

/* @return whether a mail was received */
static bool fetch(bridge_t *b)
{
    const ec_slavet *slave = &ec_slave[b->slave];
    ec_mbxbuft mail;
    ec_clearmbx(&mail);
    if (!mail_waits(b))
        return false;
    while (ec_FPRD(slave->configadr, slave->mbx_ro, slave->mbx_rl, &mail, EC_TIMEOUTRET) <= 0) {
        if (!request_again(b))
            return false;
    }
    if (is_repeated(b, (const ec_mbxheadert *)&mail))
        return true;
    uint8 type = ((const ec_mbxheadert *)&mail)->mbxtype & 0x0F;
    b->mails++;
    if (type == ECT_MBXT_EOE)
        take_fragment(b, &mail);
    if (type != ECT_MBXT_COE || !b->waits || is_emergency(&mail))
        return true;
    b->waits = false;
    b->sdos++;
    b->sdo_due_ns = master_now() + SDO_PAUSE_NS;
    b->most_mails = b->mails > b->most_mails ? b->mails : b->most_mails;
    return true;
}

/* --- the bridge --------------------------------------------------------------------------------------------------- */

static void run(bridge_t *b)
{
    while (!master_ended) {
        prepare_next(b);
        bool sent = send_mail(b);
        if (!fetch(b) && !sent && !b->due)
            osal_usleep(QUIET_US);
    }
}

/* Sets the slave's IP address, in a /24, before any frame, because the reply must be the first EoE mail. */
static bool set_address(const settings_t *s, uint16 slave)
{
    eoe_param_t wanted = {.ip_set = 1, .subnet_set = 1};
    struct in_addr ip;
    if (!s->address)
        return true;
    if (inet_pton(AF_INET, s->address, &ip) == 1) {
        wanted.ip.addr = ip.s_addr;
        wanted.subnet.addr = htonl(0xFFFFFF00);
        if (ecx_EOEsetIp(&ecx_context, slave, 0, &wanted, EC_TIMEOUTRXM) > 0)
            return true;
    }
    fprintf(stderr, "slave %u does not take the address '%s': it has no EoE, or this is no IPv4 address\n",
            (unsigned int)slave, s->address);
    return false;
}

/* @return -1: the reason is on standard error */
static int open_tap(const char *name)
{
    struct ifreq request = {.ifr_flags = IFF_TAP | IFF_NO_PI};
    int fd = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
    int control = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
    if (fd < 0 || control < 0 || ioctl(fd, TUNSETIFF, &request) < 0) {
        fprintf(stderr, "cannot make the TAP '%s': %s; this needs CAP_NET_ADMIN (sudo, or run it by 'ectwin with')\n",
                name, strerror(errno));
        return -1;
    }
    request.ifr_flags = IFF_UP;
    (void)ioctl(control, SIOCSIFFLAGS, &request);
    close(control);
    return fd;
}

/* Tries several times, because SOEM waits only 2 ms for each frame, and a busy machine is late. @return whether the
 * slave is in PREOP with a mailbox for EoE */
static bool to_preop(const settings_t *s)
{
    for (int tries = 0; tries < TRIES && !master_ended; tries++) {
        if (ec_config_init(FALSE) >= (int)s->slave && ec_slave[s->slave].mbx_l >= HEADERS + UNIT &&
            ec_statecheck((uint16)s->slave, EC_STATE_PRE_OP, EC_TIMEOUTSTATE) == EC_STATE_PRE_OP)
            return true;
    }
    fprintf(stderr, "slave %u does not answer on '%s', or has no mailbox for EoE\n", s->slave, s->iface);
    return false;
}

static int bridge(const settings_t *s)
{
    static bridge_t b;
    b.slave = (uint16)s->slave;
    b.sdo = s->sdo;
    if (!to_preop(s))
        return MASTER_FAILED;
    if (!set_address(s, b.slave))
        return MASTER_FAILED;
    b.tap = open_tap(s->tap);
    if (b.tap < 0)
        return MASTER_OPEN;
    printf("{\"event\":\"ready\",\"tap\":\"%s\",\"slave\":%u}\n", s->tap, s->slave);
    run(&b);
    printf("{\"event\":\"end\",\"to_slave\":%" PRIu64 ",\"from_slave\":%" PRIu64 ",\"broken\":%" PRIu64
           ",\"sdos\":%" PRIu64 ",\"most_mails\":%u}\n",
           b.to_slave, b.from_slave, b.broken, b.sdos, b.most_mails);
    close(b.tap);
    return 0;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    switch (key) {
    case 't':
        if (*text == 0 || strlen(text) >= IFNAMSIZ)
            argp_error(state, "--tap takes a name of 1 to %d characters, not '%s'", IFNAMSIZ - 1, text);
        s->tap = text;
        return 0;
    case 'a':
        s->address = text;
        return 0;
    case 'n':
        s->slave = master_number(state, "--slave", text, 1, EC_MAXSLAVE - 1);
        return 0;
    case 's':
        s->sdo = true;
        return 0;
    default:
        return master_parse_iface(key, text, state, &s->iface);
    }
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"tap", 't', "NAME", 0, "Name of the TAP interface (default eoe0)", 0},
        {"address", 'a', "IP", 0, "IPv4 address to set in the slave, in a /24 (default: the address is not set)", 0},
        {"slave", 'n', "N", 0, "Position of the slave, from 1 (default 1)", 0},
        {"sdo", 's', NULL, 0, "Upload an SDO every 10 ms between the fragments", 0},
        {0},
    };
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "IFACE",
        .doc = "Bridges a TAP interface and a slave with EoE, in PREOP, until SIGINT or SIGTERM. Prints a line of "
               "JSON at the start, and another at the end with the frames of both directions."};
    settings_t s = {.tap = "eoe0", .slave = 1};
    argp_err_exit_status = MASTER_USAGE;
    setvbuf(stdout, NULL, _IOLBF, 0);
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    master_catch_signals();
    if (!master_open(argv[0], s.iface))
        return MASTER_OPEN;
    int status = bridge(&s);
    master_close();
    return status;
}
