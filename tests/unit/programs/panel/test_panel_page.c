/* SPDX-License-Identifier: MIT */
/* A bus and a page of the panel without sockets (link.h, table.h, bus.h, page.h): bytes in, messages out. */
#include "page.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define TOKEN "0123456789abcdef0123456789abcdef"

static buses_t buses;
static bus_t *bus;
static page_t *page;
static char message[PAGE_MESSAGE];

static void take_reply(void *ctx, const bus_t *from, const link_request_t *request, const char *text)
{
    (void)ctx;
    assert_ptr_equal(from, bus);
    if (request->page == page->number)
        page_reply(page, request->id, text);
}

static int begin(void **state)
{
    (void)state;
    bus = calloc(1, sizeof *bus);
    page = calloc(1, sizeof *page);
    assert_true(bus && page);
    bus->number = 1;
    page->number = 5;
    buses = (buses_t){.count = 1, .all = {bus}, .reply = take_reply};
    bus_connected(&buses, bus, 77);
    return 0;
}

static int finish(void **state)
{
    (void)state;
    table_clear(&bus->table);
    free(bus);
    free(page);
    return 0;
}

static void from_bus(const char *text)
{
    assert_true(bus_take(&buses, bus, text, strlen(text)));
}

static page_action_t from_page(const char *text)
{
    static page_passed_t passed;
    page_action_t action = page_take(page, text, strlen(text), TOKEN, &passed);
    if (action == PAGE_PASS_ON) {
        const link_request_t request = {.kind = LINK_PAGE, .page = page->number, .id = passed.id};
        assert_int_equal(passed.bus, 1);
        assert_true(link_ask(&bus->link, passed.line, &request));
    }
    return action;
}

/* The next message is this one; "": none. */
static void expect(const char *text)
{
    size_t length = page_next(page, &buses, message);
    assert_true(length < sizeof message);
    message[length] = 0;
    assert_string_equal(message, text);
}

static void expect_requests(const char *text)
{
    bus->link.out[bus->link.unsent] = 0;
    assert_string_equal(bus->link.out, text);
    link_sent(&bus->link, bus->link.unsent);
}

static void skip_message(void)
{
    assert_true(page_next(page, &buses, message) > 0);
}

#define ABOUT         "{\"op\":\"about\"}\n"
#define EVENTS(after) "{\"op\":\"events\",\"after\":" after "}\n"
#define POLLED        ABOUT "{\"op\":\"list\",\"slave\":0}\n{\"op\":\"stats\"}\n{\"op\":\"fault\"}\n" EVENTS("0")
#define SIGNAL_A      "{\"slave\":1,\"name\":\"a\",\"value\":1,\"access\":\"rw\",\"range\":\"0..1\",\"meaning\":\"m\"}"
#define SIGNAL_B      "{\"slave\":2,\"name\":\"a\",\"value\":1,\"access\":\"r\",\"range\":\"0..1\",\"meaning\":\"m\"}"
#define OK            "{\"ok\":true}\n"

/* A page that shows the bus, which has two signals; all messages up to the values are taken. */
static void open_bus(void)
{
    expect_requests(ABOUT);
    from_bus("{\"devices\":\"fzm1\",\"slaves\":2}\n" OK);
    assert_int_equal(from_page("{\"token\":\"" TOKEN "\"}"), PAGE_DONE);
    expect("{\"event\":\"hello\",\"version\":\"" ECTWIN_VERSION "\",\"view\":false}");
    expect(
        "{\"event\":\"buses\",\"buses\":[{\"bus\":1,\"process\":77,\"about\":{\"devices\":\"fzm1\",\"slaves\":2}}]}");
    expect("");
    assert_int_equal(from_page("{\"open\":1}"), PAGE_LEAVE);
    bus_poll(bus, true);
    expect_requests(POLLED);
    from_bus("{\"devices\":\"fzm1\",\"slaves\":2}\n" OK SIGNAL_A "\n" SIGNAL_B "\n" OK);
    expect_requests("{\"op\":\"watch\",\"slave\":0}\n");
    from_bus("{\"frames\":1}\n{\"answers\":[]}\n" OK "{\"fault\":\"drop \\\"5%\"}\n{\"fault\":\"reorder\"}\n" OK OK OK);
    expect("{\"event\":\"signals\",\"bus\":1,\"of\":2,\"from\":0,\"signals\":[" SIGNAL_A "," SIGNAL_B "]}");
    expect("{\"event\":\"faults\",\"bus\":1,\"faults\":[\"drop \\\"5%\",\"reorder\"]}");
    expect("{\"event\":\"stats\",\"bus\":1,\"counters\":{\"frames\":1},\"answers\":{\"answers\":[]}}");
    expect("");
}

static void values(void **state)
{
    (void)state;
    open_bus();
    from_bus("{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":1.5}\n");
    expect(""); /* not yet */
    page->due = true;
    expect("{\"event\":\"values\",\"bus\":1,\"values\":[[0,1]]}");
    expect("");
    page->due = true;
    expect(""); /* without a change */
    for (int i = 0; i < 1000; i++)
        from_bus("{\"slave\":2,\"name\":\"a\",\"value\":\"x\\\"\",\"time\":1.5}\n{\"slave\":2,\"name\":\"a\",\"value\":"
                 "2,\"time\":1.6}\n");
    page->due = true;
    expect("{\"event\":\"values\",\"bus\":1,\"values\":[[1,2]]}");
    from_bus("{\"slave\":2,\"name\":\"a\",\"value\":18446744073709551615,\"time\":1.7}\n"
             "{\"slave\":3,\"name\":\"a\",\"value\":1,\"time\":1.7}\n{\"slave\":1,\"name\":\"b\",\"value\":1,\"time\":"
             "1.7}\n");
    page->due = true;
    expect("{\"event\":\"values\",\"bus\":1,\"values\":[[1,\"18446744073709551615\"]]}");
    expect("");
}

static void requests(void **state)
{
    (void)state;
    open_bus();
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"set\",\"name\":\"a\",\"value\":1}}"),
                     PAGE_PASS_ON);
    bus_poll(bus, true); /* waits: a reply is missing */
    expect_requests("{\"op\":\"set\",\"name\":\"a\",\"value\":1}\n");
    from_bus("{\"slave\":1,\"name\":\"a\",\"value\":0,\"time\":2}\n{\"ok\":false,\"message\":\"no\"}\n");
    expect("{\"event\":\"reply\",\"id\":9,\"reply\":{\"ok\":false,\"message\":\"no\"}}");
    bus_poll(bus, true);
    expect_requests(ABOUT "{\"op\":\"stats\"}\n{\"op\":\"fault\"}\n" EVENTS("0"));
    assert_int_equal(from_page("{\"id\":1,\"bus\":1,\"request\":{\"op\":\"watch\"}}"), PAGE_DONE);
    expect("{\"event\":\"reply\",\"id\":1,\"reply\":{\"ok\":false,\"message\":\"the panel does not pass this request "
           "on\"}}");
    page->view = true;
    assert_int_equal(from_page("{\"id\":2,\"bus\":1,\"request\":{\"op\":\"set\"}}"), PAGE_DONE);
    expect("{\"event\":\"reply\",\"id\":2,\"reply\":{\"ok\":false,\"message\":\"this panel was started with --view: it "
           "changes "
           "nothing\"}}");
}

#define HOLD(bus, name, value, rest)                                                                                   \
    "{\"id\":1,\"bus\":" bus ",\"request\":{\"op\":\"set\",\"slave\":1,\"name\":\"" name "\",\"value\":" value         \
    "},\"rest\":" rest "}"
#define RELEASE(name, rest) "{\"op\":\"set\",\"slave\":1,\"name\":\"" name "\",\"value\":" rest "}"

static void expect_released(unsigned int number, const char *line)
{
    static page_passed_t passed;
    assert_true(page_release(page, &passed));
    assert_int_equal(passed.bus, number);
    assert_string_equal(passed.line, line);
    assert_true(passed.id == 0); /* no request of the page */
    passed.id = 1;
}

static page_action_t take_hold(const char *text)
{
    static page_passed_t passed;
    page->waiting = 0;
    page->replies = 0;
    return page_take(page, text, strlen(text), TOKEN, &passed);
}

static void held_signals(void **state)
{
    page_passed_t passed;
    (void)state;
    open_bus();
    assert_false(page_release(page, &passed));
    assert_int_equal(take_hold(HOLD("1", "x", "0", "0")), PAGE_PASS_ON);
    assert_false(page_release(page, &passed));
    assert_int_equal(take_hold(HOLD("1", "x", "500", "0")), PAGE_PASS_ON);
    assert_int_equal(take_hold(HOLD("1", "x", "-700", "0")), PAGE_PASS_ON);
    assert_int_equal(take_hold(HOLD("2", "x", "5", "0")), PAGE_PASS_ON);
    assert_int_equal(take_hold(HOLD("1", "y", "1", "-1")), PAGE_PASS_ON);
    assert_int_equal(take_hold(HOLD("1", "x", "0", "0")), PAGE_PASS_ON);
    assert_int_equal(take_hold(HOLD("1", "z", "{\"A\":1}", "{\"a\":1}")), PAGE_PASS_ON);
    expect_released(1, RELEASE("z", "{\"a\":1}"));
    expect_released(2, RELEASE("x", "0"));
    expect_released(1, RELEASE("y", "-1"));
    assert_false(page_release(page, &passed));
}

static void refused_holds(void **state)
{
    static const struct {
        const char *message, *reason;
    } table[] = {
        {"{\"id\":1,\"bus\":1,\"request\":{\"op\":\"set\",\"values\":{\"a\":1}},\"rest\":0}", "that set one signal"},
        {"{\"id\":1,\"bus\":1,\"request\":{\"op\":\"fault\",\"fault\":\"off\"},\"rest\":0}", "that set one signal"},
        {"{\"id\":1,\"bus\":1,\"request\":{\"op\":\"set\",\"value\":1},\"rest\":0}", "that set one signal"},
        {"{\"id\":1,\"bus\":1,\"request\":{\"op\":\"set\",\"name\":\"a\"},\"rest\":0}", "that set one signal"},
        {"{\"id\":1,\"bus\":1,\"request\":{\"op\":\"set\",\"name\":\"a\",\"value\":1,\"at\":9},\"rest\":0}", "at once"},
        {HOLD("1", "a", "1",
              "\"0123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890"
              "1234567890123456789012345678901234567890123456789012345678901234567890123456789012345678901"
              "2345678901234567890123456789012345678901234567890123456789012345678901234567890\""),
         "too much"},
    };
    page_passed_t passed;
    (void)state;
    open_bus();
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        assert_int_equal(take_hold(table[i].message), PAGE_DONE);
        skip_message();
        assert_non_null(strstr(message, table[i].reason));
        assert_false(page_release(page, &passed));
    }
}

static void a_page_that_holds_too_much(void **state)
{
    char text[256];
    page_passed_t passed;
    (void)state;
    open_bus();
    for (int i = 0; i <= PAGE_HELD; i++) {
        snprintf(text, sizeof text,
                 "{\"id\":1,\"bus\":1,\"request\":{\"op\":\"set\",\"name\":\"x%d\",\"value\":1},\"rest\":0}", i);
        assert_int_equal(take_hold(text), i < PAGE_HELD ? PAGE_PASS_ON : PAGE_DONE);
    }
    skip_message();
    assert_non_null(strstr(message, "at most 16 signals"));
    for (int i = 0; i < PAGE_HELD; i++)
        assert_true(page_release(page, &passed));
    assert_false(page_release(page, &passed));
}

static void a_view_holds_nothing(void **state)
{
    page_passed_t passed;
    (void)state;
    open_bus();
    page->view = true;
    assert_int_equal(take_hold(HOLD("1", "x", "500", "0")), PAGE_DONE);
    assert_false(page_release(page, &passed));
}

static size_t members(const char *text, const char *begin_of_one)
{
    size_t count = 0;
    for (text = strstr(text, begin_of_one); text; text = strstr(text + 1, begin_of_one))
        count++;
    return count;
}

#define EVENT(number) "{\"number\":" number ",\"slave\":1,\"event\":\"state\",\"text\":\"OP\"}"

static void events(void **state)
{
    (void)state;
    open_bus();
    bus_poll(bus, true);
    expect_requests(ABOUT "{\"op\":\"stats\"}\n{\"op\":\"fault\"}\n" EVENTS("0"));
    from_bus(OK OK OK EVENT("8") "\n" EVENT("9") "\n" OK);
    expect_requests(EVENTS("9")); /* until there are no more */
    skip_message();               /* faults */
    expect("{\"event\":\"events\",\"bus\":1,\"events\":[" EVENT("8") "," EVENT("9") "]}");
    from_bus(EVENT("9") "\n{\"number\":\"x\"}\n" OK);
    expect_requests("");
    expect("");
    bus_poll(bus, true);
    expect_requests(ABOUT "{\"op\":\"stats\"}\n{\"op\":\"fault\"}\n" EVENTS("9"));
    assert_int_equal(from_page("{\"open\":1}"), PAGE_LEAVE); /* again: all that are kept */
    size_t length;
    while ((length = page_next(page, &buses, message)) > 0 && !strstr(message, "\"events\"")) {
    }
    message[length] = '\0';
    assert_non_null(strstr(message, EVENT("8") "," EVENT("9")));
}

static void events_of_another_connection(void **state)
{
    (void)state;
    open_bus();
    bus_poll(bus, true);
    from_bus(OK OK OK EVENT("8") "\n" EVENT("9") "\n" OK);
    while (page_next(page, &buses, message) > 0) {
    }
    bus_disconnected(&buses, bus);
    bus_connected(&buses, bus, 78);
    from_bus("{\"devices\":\"fzm1\",\"slaves\":2}\n" OK);
    bus_poll(bus, true);
    from_bus("{\"devices\":\"fzm1\",\"slaves\":2}\n" OK SIGNAL_B "\n" OK
             "{\"frames\":1}\n{\"answers\":[]}\n" OK OK EVENT("1") "\n" OK);
    size_t length;
    while ((length = page_next(page, &buses, message)) > 0 && !strstr(message, "\"events\"")) {
    }
    message[length] = '\0';
    assert_string_equal(message, "{\"event\":\"events\",\"bus\":1,\"events\":[" EVENT("1") "]}");
}

static void many_events(void **state)
{
    char line[2 * BUS_EVENT];
    (void)state;
    open_bus();
    bus_poll(bus, true);
    from_bus(OK OK OK);
    skip_message();
    for (int i = 1; i <= BUS_EVENTS + 10; i++) {
        snprintf(line, sizeof line, "{\"number\":%d,\"text\":\"%0400d\"}\n", i, i);
        from_bus(line);
    }
    snprintf(line, sizeof line, "{\"number\":99,\"text\":\"%0600d\"}\n", 0);
    from_bus(line); /* too long, and omitted */
    size_t count = 0;
    for (size_t length; (length = page_next(page, &buses, message)) > 0; count += members(message, "\"number\"")) {
        message[length] = 0;
        assert_true(count > 0 || strstr(message, "\"number\":11,"));
    }
    assert_int_equal(count, BUS_EVENTS);
    from_bus(OK);
    expect_requests(ABOUT "{\"op\":\"stats\"}\n{\"op\":\"fault\"}\n" EVENTS("0") EVENTS("99"));
}

static void replies_of_several_lines(void **state)
{
    (void)state;
    open_bus();
    page->view = true; /* which may read */
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
    assert_int_equal(from_page("{\"id\":10,\"bus\":1,\"request\":{\"op\":\"read\",\"index\":1}}"), PAGE_PASS_ON);
    from_bus("{\"index\":1}\n{\"index\":2}\n" OK "{\"index\":1,\"value\":3}\n" OK);
    expect("{\"event\":\"reply\",\"id\":9,\"reply\":{\"ok\":true,\"lines\":[{\"index\":1},{\"index\":2}]}}");
    expect("{\"event\":\"reply\",\"id\":10,\"reply\":{\"ok\":true,\"lines\":[{\"index\":1,\"value\":3}]}}");
    assert_int_equal(from_page("{\"id\":11,\"bus\":1,\"request\":{\"op\":\"write\",\"index\":1}}"), PAGE_DONE);
    skip_message();
    assert_non_null(strstr(message, "--view"));
}

static void too_many_lines(void **state)
{
    char line[1024];
    (void)state;
    open_bus();
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
    snprintf(line, sizeof line, "{\"name\":\"%0900d\"}\n", 0);
    for (int i = 0; i < 10; i++)
        from_bus(line);
    from_bus(OK);
    expect(
        "{\"event\":\"reply\",\"id\":9,\"reply\":{\"ok\":false,\"message\":\"the reply is too long for this panel\"}}");
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
    from_bus("{}\n" OK);
    expect("{\"event\":\"reply\",\"id\":9,\"reply\":{\"ok\":true,\"lines\":[{}]}}");
}

static void a_long_reply(void **state)
{
    static char text[2 * PAGE_REPLY];
    (void)state;
    open_bus();
    snprintf(text, sizeof text, "%0*d", PAGE_REPLY, 0);
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"set\"}}"), PAGE_PASS_ON);
    page_reply(page, 9, text);
    expect(
        "{\"event\":\"reply\",\"id\":9,\"reply\":{\"ok\":false,\"message\":\"the reply is too long for this panel\"}}");
}

static void too_many_requests(void **state)
{
    (void)state;
    open_bus();
    for (int i = 0; i < 3 * PAGE_REPLIES; i++) { /* each with its reply */
        assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"set\"}}"), PAGE_PASS_ON);
        from_bus(OK);
        expect("{\"event\":\"reply\",\"id\":9,\"reply\":{\"ok\":true}}");
        expect_requests("{\"op\":\"set\"}\n");
    }
    for (int i = 0; i < PAGE_REPLIES; i++)
        assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"set\"}}"), PAGE_PASS_ON);
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"set\"}}"), PAGE_CLOSE);
}

static void add_signal(const char *name, size_t length)
{
    static char text[PAGE_MESSAGE];
    const int zeros = (int)(length - strlen("{\"slave\":1,\"name\":\"a\",\"m\":\"\"}"));
    snprintf(text, sizeof text, "{\"slave\":1,\"name\":\"%s\",\"m\":\"%0*d\"}", name, zeros, 0);
    assert_int_equal(strlen(text), length);
    cJSON *line = cJSON_Parse(text);
    assert_true(table_add(&bus->table, text, line));
    cJSON_Delete(line);
}

/* A message has room for eight bytes more than its pieces, terminator included. */
static void messages_that_just_fit(void **state)
{
    enum { FIRST = 20000, LONGEST = PAGE_MESSAGE - 8 - 1 + 2 };
    static const char head[] = "{\"event\":\"signals\",\"bus\":1,\"of\":2,\"from\":0,\"signals\":[";
    (void)state;
    open_bus();
    for (int more = -3; more < 20; more++) {
        const size_t whole = (size_t)(LONGEST + more), second = whole - strlen(head) - FIRST - strlen(",]}");
        table_clear(&bus->table);
        bus->generation++;
        add_signal("a", FIRST);
        add_signal("b", second);
        const size_t length = page_next(page, &buses, message);
        assert_int_equal(length, more <= 0 ? whole : whole - second - 1);
        assert_memory_equal(message + length - 2, "]}", 2);
        if (more > 0)
            assert_int_equal(page_next(page, &buses, message), strlen(head) + second + 2);
        assert_int_equal(page->described, 2);
    }
}

static void a_bus_opened_again(void **state)
{
    static const link_request_t watch = {.kind = LINK_WATCH}, later = {.kind = LINK_EVENTS};
    static const char *const all[] = {
        "{\"event\":\"trouble\",\"bus\":1,\"message\":\"b\"}",
        "{\"event\":\"signals\",\"bus\":1,\"of\":2,\"from\":0,\"signals\":[" SIGNAL_A "," SIGNAL_B "]}",
        "{\"event\":\"faults\",\"bus\":1,\"faults\":[\"drop \\\"5%\",\"reorder\"]}",
        "{\"event\":\"events\",\"bus\":1,\"events\":[" EVENT("1") "]}",
        "{\"event\":\"stats\",\"bus\":1,\"counters\":{\"frames\":1},\"answers\":{\"answers\":[]}}",
        "{\"event\":\"values\",\"bus\":1,\"values\":[[0,1]]}",
    };
    (void)state;
    open_bus();
    assert_true(link_ask(&bus->link, "{}", &later));
    from_bus(EVENT("1") "\n" OK OK);
    assert_true(link_ask(&bus->link, "{}", &watch));
    from_bus("{\"ok\":false,\"message\":\"b\"}\n{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":1.5}\n");
    while (page_next(page, &buses, message) > 0) {
    }
    for (unsigned int times = 0; times < 2; times++) {
        assert_int_equal(from_page("{\"open\":1}"), PAGE_LEAVE);
        page->due = true;
        for (size_t i = 0; i < sizeof all / sizeof *all; i++)
            expect(all[i]);
        expect("");
    }
}

/* A request for a twin has less room than a message of a page. */
static void a_long_request(void **state)
{
    static const struct {
        size_t spaces; /* in its text */
        page_action_t action;
    } rows[] = {{REQUEST_LINE - 100, PAGE_PASS_ON}, {REQUEST_LINE, PAGE_DONE}};
    char text[REQUEST_TEXT];
    (void)state;
    open_bus();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        snprintf(text, sizeof text,
                 "{\"id\":%zu,\"bus\":1,\"request\":{\"op\":\"set\",\"name\":\"a\",\"value\":\"%*s\"}}", i,
                 (int)rows[i].spaces, "");
        if (from_page(text) != rows[i].action)
            fail_msg("a request of %zu bytes: expected action %d", strlen(text), (int)rows[i].action);
    }
    expect("{\"event\":\"reply\",\"id\":1,\"reply\":{\"ok\":false,\"message\":\"too much for one request\"}}");
}

#define TEN_CONTROLS "\\u0001\\u0001\\u0001\\u0001\\u0001\\u0001\\u0001\\u0001\\u0001\\u0001"

/* The reason has at most 512 bytes in a message; a longer one is left out. */
static void a_refused_watch(void **state)
{
    static const struct {
        const char *reply, *trouble;
    } rows[] = {
        {"{\"ok\":false,\"message\":\"a \\\"b\\\"\"}\n", "a \\\"b\\\""},
        {"{\"ok\":false,\"message\":\"" TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS
         "\"}\n",
         TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS},
        {"{\"ok\":false,\"message\":\"" TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS
             TEN_CONTROLS TEN_CONTROLS TEN_CONTROLS "\"}\n",
         "the signals are not shown"},
        {"{\"ok\":false}\n", "the twin does not report its signals"},
        {"{\"ok\":false,\"message\":7}\n", "the twin does not report its signals"}};
    char want[1024];
    (void)state;
    open_bus();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const link_request_t request = {.kind = LINK_WATCH};
        assert_true(link_ask(&bus->link, "{}", &request));
        from_bus(rows[i].reply);
        snprintf(want, sizeof want, "{\"event\":\"trouble\",\"bus\":1,\"message\":\"%s\"}", rows[i].trouble);
        expect(want);
        expect("");
    }
}

static void rules(void **state)
{
    static const char *const bad[] = {"{\"token\":\"\"}", "{\"token\":1}", "{}", "{\"open\":1}", "", "{", "[]", "1"};
    static const char *const bad_later[] = {"{\"id\":1}", "{\"request\":{\"op\":\"set\"}}", "{\"id\":1,\"request\":[]}",
                                            "{}"};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(from_page(bad[i]), PAGE_CLOSE);
        expect("");
    }
    assert_int_equal(from_page("{\"token\":\"" TOKEN "\"}"), PAGE_DONE);
    for (size_t i = 0; i < sizeof bad_later / sizeof *bad_later; i++)
        assert_int_equal(from_page(bad_later[i]), PAGE_CLOSE);
    assert_int_equal(from_page("{\"open\":-1}"), PAGE_LEAVE);
    assert_int_equal(page->bus, 0);
}

/* Signals with long texts, so that a message has a few of them only. */
static void add_signals(int count)
{
    char line[LINK_LINE];
    for (int i = 0; i < count; i++) {
        snprintf(line, sizeof line,
                 "{\"slave\":1,\"name\":\"long%d\",\"value\":1,\"access\":\"r\",\"meaning\":\"%03000d\"}\n", i, i);
        from_bus(line);
    }
}

static void many_signals(void **state)
{
    enum { COUNT = 40 };
    char line[LINK_LINE];
    size_t described = 0, changed = 0, messages = 0;
    (void)state;
    expect_requests(ABOUT);
    from_bus(OK);
    assert_int_equal(from_page("{\"token\":\"" TOKEN "\"}"), PAGE_DONE);
    assert_int_equal(from_page("{\"open\":1}"), PAGE_LEAVE);
    bus_poll(bus, true);
    from_bus(OK);
    add_signals(COUNT);
    from_bus(OK);
    for (int i = 0; i < COUNT; i++) {
        snprintf(line, sizeof line, "{\"slave\":1,\"name\":\"long%d\",\"value\":\"%03000d\",\"time\":1}\n", i, i);
        from_bus(line);
    }
    page->due = true;
    for (size_t length; (length = page_next(page, &buses, message)) > 0; messages++) {
        assert_true(length < sizeof message);
        message[length] = 0;
        cJSON *parsed = cJSON_Parse(message);
        assert_non_null(parsed);
        cJSON_Delete(parsed);
        described += members(message, "{\"slave\":1");
        changed += strstr(message, "\"values\"") ? members(message, ",\"00") : 0;
    }
    assert_int_equal(described, COUNT);
    assert_int_equal(changed, COUNT);
    assert_true(messages > 8);
}

static void too_many_signals(void **state)
{
    char line[LINK_LINE];
    (void)state;
    from_bus(OK);
    assert_int_equal(from_page("{\"token\":\"" TOKEN "\"}"), PAGE_DONE);
    assert_int_equal(from_page("{\"open\":1}"), PAGE_LEAVE);
    bus_poll(bus, true);
    from_bus(OK);
    for (int i = 0; i <= TABLE_SIGNALS; i++) {
        snprintf(line, sizeof line, "{\"slave\":1,\"name\":\"s%d\",\"value\":1}\n", i);
        from_bus(line);
    }
    from_bus(OK);
    assert_false(bus->listed);
    skip_message();
    skip_message();
    expect("{\"event\":\"trouble\",\"bus\":1,\"message\":\"this bus has more than 4096 signals: the panel shows none "
           "of them\"}");
    bus_connected(&buses, bus, 78); /* again, with a signal less */
    bus_poll(bus, false);
    from_bus(OK);
    bus_poll(bus, true);
    from_bus(OK SIGNAL_A "\n" OK);
    assert_true(bus->listed);
    skip_message();
    expect("{\"event\":\"signals\",\"bus\":1,\"of\":1,\"from\":0,\"signals\":[" SIGNAL_A "]}");
    assert_int_equal(from_page("{\"open\":1}"), PAGE_LEAVE); /* once more: the trouble is over */
    expect("{\"event\":\"signals\",\"bus\":1,\"of\":1,\"from\":0,\"signals\":[" SIGNAL_A "]}");
}

#define ENDED "{\"ok\":false,\"message\":\"the connection to the bus has ended\"}"

/* Half a reply of a connection is no part of a reply of the next one. */
static void half_a_reply(void **state)
{
    (void)state;
    open_bus();
    assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
    from_bus("{\"index\":1}\n");
    bus_connected(&buses, bus, 78);
    from_bus(OK);
    assert_int_equal(from_page("{\"id\":10,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
    from_bus("{\"index\":2}\n" OK);
    assert_int_equal(page->replies, 2);
    assert_string_equal(page->reply[page->first].text, ENDED);
    assert_string_equal(page->reply[(page->first + 1) % PAGE_REPLIES].text, "{\"ok\":true,\"lines\":[{\"index\":2}]}");
}

/* The twin has replied to the first request of the panel only, and the connection ends again and again: requests of the
 * panel itself get no reply, those of the page one each. */
static void requests_of_an_ended_connection(void **state)
{
    (void)state;
    open_bus();
    for (int i = 0; i < 3 * PAGE_REPLIES; i++) {
        bus_poll(bus, true);
        assert_int_equal(from_page("{\"id\":8,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
        assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"waves\"}}"), PAGE_PASS_ON);
        from_bus(OK);
        bus_disconnected(&buses, bus);
        expect("{\"event\":\"reply\",\"id\":8,\"reply\":" ENDED "}");
        expect("{\"event\":\"reply\",\"id\":9,\"reply\":" ENDED "}");
        assert_int_equal(page->replies, 0);
        bus_connected(&buses, bus, 78);
        from_bus(OK);
    }
}

/* The same of lists of faults, and of events, which a request for more follows. */
static void half_a_list(void **state)
{
    static const char *const rows[] = {OK OK "{\"fault\":\"a\"}\n", OK OK OK EVENT("8") "\n"};
    (void)state;
    open_bus();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        bus_poll(bus, true);
        from_bus(rows[i]);
        bus_connected(&buses, bus, 78);
        expect_requests(ABOUT);
        from_bus(OK);
        bus_poll(bus, true);
        expect_requests(POLLED);
        from_bus(OK SIGNAL_A "\n" OK);
        expect_requests("{\"op\":\"watch\",\"slave\":0}\n");
        from_bus(OK "{\"fault\":\"b\"}\n" OK OK OK);
        expect_requests("");
        assert_string_equal(bus->faults.text, "[\"b\"]");
        assert_int_equal(bus->events, 0);
    }
}

/* The longest reply that a page gets, and one with a byte more. */
static void lines_that_just_fit(void **state)
{
    char line[LINK_LINE];
    (void)state;
    open_bus();
    for (int more = 0; more < 2; more++) {
        assert_int_equal(from_page("{\"id\":9,\"bus\":1,\"request\":{\"op\":\"objects\"}}"), PAGE_PASS_ON);
        const int lengths[] = {4090, 4090, BUS_LINES - 2 - 2 * 4090 - 2 + more};
        for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
            (void)snprintf(line, sizeof line, "{\"n\":\"%0*d\"}\n", lengths[i] - (int)strlen("{\"n\":\"\"}"), 0);
            from_bus(line);
        }
        from_bus(OK);
        const char *reply = page->reply[page->first].text;
        if (more == 0)
            assert_int_equal(strlen(reply), strlen("{\"ok\":true,\"lines\":[]}") + BUS_LINES - 2);
        else
            assert_non_null(strstr(reply, "the reply is too long for this panel"));
        skip_message();
    }
}

static void faults_of_each_reply(void **state)
{
    (void)state;
    open_bus();
    bus_poll(bus, true);
    from_bus(OK "{\"frames\":2}\n" OK "{\"fault\":\"drop\"}\n{\"other\":1}\n" OK);
    expect("{\"event\":\"faults\",\"bus\":1,\"faults\":[\"drop\"]}");
    expect("{\"event\":\"stats\",\"bus\":1,\"counters\":{\"frames\":2},\"answers\":{\"answers\":[]}}");
    from_bus(OK);
    bus_poll(bus, true);
    from_bus(OK OK "{\"other\":1}\n" OK);
    expect("{\"event\":\"faults\",\"bus\":1,\"faults\":[]}");
}

static void faults_that_just_fit(void **state)
{
    enum { FIRST = 2000, SECOND = BUS_TEXT - FIRST - 4 };
    char line[LINK_LINE];
    (void)state;
    from_bus(OK);
    for (int more = 0; more < 2; more++) {
        bus_poll(bus, true);
        from_bus(more == 0 ? OK OK OK : OK OK);
        (void)snprintf(line, sizeof line, "{\"fault\":\"%0*d\"}\n", FIRST - 2, 0);
        from_bus(line);
        (void)snprintf(line, sizeof line, "{\"fault\":\"%0*d\"}\n", SECOND - 2 + more, 0);
        from_bus(line);
        from_bus(OK OK);
        assert_int_equal(bus->faults.length, more == 0 ? BUS_TEXT - 1 : FIRST + 2);
        if (more == 0)
            from_bus(OK); /* of the watch */
    }
}

static void buses_by_their_number(void **state)
{
    static bus_t others[2] = {{.number = 7}, {.number = 9}};
    (void)state;
    buses.all[1] = &others[0];
    buses.all[2] = &others[1];
    buses.count = 3;
    assert_ptr_equal(bus_find(&buses, 1), bus);
    assert_ptr_equal(bus_find(&buses, 7), &others[0]);
    assert_ptr_equal(bus_find(&buses, 9), &others[1]);
    assert_null(bus_find(&buses, 8));
    assert_null(bus_find(&buses, 0));
}

/* A bus that has not described itself yet is not in the list. */
static void list_of_buses(void **state)
{
    static bus_t others[3] = {{.number = 7}, {.number = 8, .process = 9}, {.number = 9}};
    (void)state;
    open_bus();
    for (size_t i = 0; i < 3; i++)
        buses.all[buses.count++] = &others[i];
    for (size_t i = 1; i < 3; i++) {
        others[i].about.version = 1;
        strcpy(others[i].about.text, "{}");
    }
    buses.changes++;
    expect("{\"event\":\"buses\",\"buses\":[{\"bus\":1,\"process\":77,\"about\":{\"devices\":\"fzm1\",\"slaves\":2}},"
           "{\"bus\":8,\"process\":9,\"about\":{}},{\"bus\":9,\"process\":0,\"about\":{}}]}");
    expect("");
}

static void another_connection(void **state)
{
    (void)state;
    open_bus();
    page->due = true;
    from_bus("{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":1.5}\n");
    skip_message();
    bus_disconnected(&buses, bus);
    skip_message(); /* the list */
    expect("");
    bus_connected(&buses, bus, 78);
    from_bus("{\"devices\":\"fzm1\",\"slaves\":2}\n" OK);
    skip_message(); /* the list */
    expect("");     /* its signals are not listed yet */
    bus_poll(bus, true);
    from_bus("{\"devices\":\"fzm1\",\"slaves\":2}\n" OK SIGNAL_B "\n");
    expect("");
    page->next = 1; /* half a pass, and a plot, of the last connection */
    trace_set_add(&page->traced, 0);
    from_bus(OK);
    expect("{\"event\":\"signals\",\"bus\":1,\"of\":1,\"from\":0,\"signals\":[" SIGNAL_B "]}");
    assert_int_equal(page->traced.count, 0);
    from_bus("{\"frames\":1}\n{\"answers\":[]}\n" OK OK OK OK
             "{\"slave\":2,\"name\":\"a\",\"value\":3,\"time\":1.5}\n");
    skip_message(); /* faults */
    page->due = true;
    expect("{\"event\":\"values\",\"bus\":1,\"values\":[[0,3]]}");
}

static void lines_of_no_twin(void **state)
{
    static const char *const bad[] = {"hello\n", "\n", "{\n"};
    static char long_one[LINK_LINE + 1];
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(bus_take(&buses, bus, bad[i], strlen(bad[i])));
    bus->link.received = 0;
    assert_false(bus_take(&buses, bus, "\0", 1));
    memset(long_one, 'x', sizeof long_one);
    assert_false(bus_take(&buses, bus, long_one, sizeof long_one));
    bus->link.received = 0;
    from_bus(OK);                                        /* of about */
    assert_false(bus_take(&buses, bus, OK, strlen(OK))); /* of nothing */
}

static void characters(void **state)
{
    static const char *const rows[][2] = {
        {"gr\xC3\xBCn \xE2\x82\xAC \xF0\x9F\x98\x80", "gr\xC3\xBCn \xE2\x82\xAC \xF0\x9F\x98\x80"},
        {"\xFF"
         "a",
         "?a"},
        {"\xC3", "?"},
        {"\xC0\xAF", "??"},
        {"\xED\xA0\x80", "???"},
        {"\xE0\x80\xAF", "???"},
        {"\xF4\x90\x80\x80", "????"},
        {"\xF0\x80\x80\x80", "????"},
        {"\xE2\x82", "??"},
        {"\xF5", "?"},
        {"\x80", "?"},
        {"a\x7F", "a\x7F"},
    };
    char line[128], expected[128];
    (void)state;
    expect_requests(ABOUT);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        snprintf(line, sizeof line, "{\"name\":\"%s\"}\n", rows[i][0]);
        snprintf(expected, sizeof expected, "{\"name\":\"%s\"}", rows[i][1]);
        from_bus(line);
        assert_string_equal(bus->about.text, expected);
    }
}

static void faults_that_do_not_fit(void **state)
{
    char line[1200];
    (void)state;
    from_bus(OK);
    bus_poll(bus, true);
    from_bus(OK OK OK);
    snprintf(line, sizeof line, "{\"fault\":\"%01000d\"}\n", 0);
    for (int i = 0; i < 10; i++)
        from_bus(line);
    from_bus("{\"fault\":\"drop\"}\n" OK);
    cJSON *list = cJSON_Parse(bus->faults.text);
    assert_int_equal(cJSON_GetArraySize(list), 5);
    cJSON_Delete(list);
}

static void from_trace(const char *text)
{
    assert_true(trace_take(&bus->trace, &bus->table, text, strlen(text)));
}

static void expect_trace_requests(const char *text)
{
    trace_t *trace = &bus->trace;
    trace_want(trace, &bus->table, &page->traced);
    trace->link.out[trace->link.unsent] = 0;
    assert_string_equal(trace->link.out, text);
    link_sent(&trace->link, trace->link.unsent);
}

#define EVERY(slave) "{\"op\":\"watch\",\"slave\":" slave ",\"pattern\":\"a\",\"every\":true}\n"

static void pulses(void **state)
{
    (void)state;
    open_bus();
    expect_trace_requests("");
    assert_int_equal(from_page("{\"trace\":[1]}"), PAGE_DONE);
    expect(""); /* not yet */
    page->due = true;
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[]}");
    expect_trace_requests(EVERY("2"));
    expect_trace_requests("");
    from_trace("{\"slave\":2,\"name\":\"a\",\"value\":0,\"time\":1.5}\n" OK
               "{\"slave\":2,\"name\":\"a\",\"value\":1,\"time\":1.501}\n"
               "{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":1.502}\n"   /* of another page */
               "{\"slave\":2,\"name\":\"b\",\"value\":1,\"time\":1.502}\n"   /* unknown */
               "{\"slave\":2,\"name\":\"a\",\"value\":\"x\",\"time\":1.5}\n" /* no number */
               "{\"slave\":2,\"name\":\"a\",\"value\":0,\"time\":1.503}\n");
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[[1,1.500000,0],[1,1.501000,1],[1,1.503000,0]]}");
    expect("");
    assert_int_equal(from_page("{\"trace\":[0,1]}"), PAGE_DONE);
    expect_trace_requests(EVERY("1"));
    from_trace(OK "{\"slave\":1,\"name\":\"a\",\"value\":0.25,\"time\":2}\n");
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[[0,2.000000,0.25]]}");
    trace_restart(&bus->trace);
    expect_trace_requests(EVERY("1") EVERY("2"));
    assert_int_equal(from_page("{\"trace\":[]}"), PAGE_DONE);
    from_trace(OK OK "{\"slave\":1,\"name\":\"a\",\"value\":0,\"time\":2}\n");
    expect("");
}

/* A page that plots again has the changes since then, not those that other pages have plotted meanwhile. */
static void a_plot_again(void **state)
{
    (void)state;
    open_bus();
    page->due = true;
    assert_int_equal(from_page("{\"trace\":[0]}"), PAGE_DONE);
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[]}");
    expect_trace_requests(EVERY("1"));
    from_trace(OK "{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":1}\n");
    assert_int_equal(from_page("{\"trace\":[0,1]}"), PAGE_DONE); /* one more: the change remains */
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[[0,1.000000,1]]}");
    assert_int_equal(from_page("{\"trace\":[]}"), PAGE_DONE);
    from_trace("{\"slave\":1,\"name\":\"a\",\"value\":0,\"time\":2}\n");
    expect("");
    assert_int_equal(from_page("{\"trace\":[0]}"), PAGE_DONE);
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[]}");
    from_trace("{\"slave\":1,\"name\":\"a\",\"value\":1,\"time\":3}\n");
    expect("{\"event\":\"changes\",\"bus\":1,\"changes\":[[0,3.000000,1]]}");
}

/* A page that is too late gets the newest changes, in messages of bounded size. */
static void a_late_page(void **state)
{
    enum { COUNT = TRACE_ROOM + 100 };
    char line[128];
    size_t sent = 0;
    (void)state;
    open_bus();
    assert_int_equal(from_page("{\"trace\":[0]}"), PAGE_DONE);
    page->due = true;
    skip_message();
    expect_trace_requests(EVERY("1"));
    from_trace(OK);
    for (int i = 0; i < COUNT; i++) {
        snprintf(line, sizeof line, "{\"slave\":1,\"name\":\"a\",\"value\":%d,\"time\":%d.5}\n", i, i);
        from_trace(line);
    }
    for (size_t length; (length = page_next(page, &buses, message)) > 0;) {
        assert_true(length < sizeof message);
        message[length] = 0;
        if (sent == 0)
            assert_non_null(strstr(message, "[[0,100.500000,100],"));
        sent += members(message, ".500000,");
    }
    assert_int_equal(sent, TRACE_ROOM);
}

static void too_many_traces(void **state)
{
    char text[8 * TRACE_SIGNALS] = "{\"trace\":[0";
    (void)state;
    open_bus();
    for (int i = 1; i < TRACE_SIGNALS; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), ",%d", i);
    snprintf(text + strlen(text), sizeof text - strlen(text), "]}");
    assert_int_equal(from_page(text), PAGE_DONE);
    text[strlen(text) - 2] = 0;
    strcat(text, ",128]}");
    assert_int_equal(from_page(text), PAGE_CLOSE);
    static const char *const bad[] = {"{\"trace\":1}", "{\"trace\":[-1]}", "{\"trace\":[4096]}", "{\"trace\":[\"a\"]}"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(from_page(bad[i]), PAGE_CLOSE);
}

/* Names with the wildcards of a pattern are not requested: they would stand for other signals too. */
static void wildcards(void **state)
{
    static const char signal[] = "{\"slave\":1,\"name\":\"a*\",\"value\":1}";
    (void)state;
    cJSON *line = cJSON_Parse(signal);
    assert_true(table_add(&bus->table, signal, line));
    cJSON_Delete(line);
    trace_set_add(&page->traced, 0);
    expect_trace_requests("");
    assert_int_equal(page->traced.count, 1);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Values are sent when they are due, the newest of each signal alone", values, begin, finish, NULL},
        {"Replies are in the order of the requests, between changes", requests, begin, finish, NULL},
        {"SEC: a signal that a page holds is released, each once, unless the page has released it", held_signals, begin,
         finish, NULL},
        {"SEC: a hold that cannot be released is refused", refused_holds, begin, finish, NULL},
        {"SEC: a page holds at most 16 signals", a_page_that_holds_too_much, begin, finish, NULL},
        {"SEC: a page of --view holds no signal", a_view_holds_nothing, begin, finish, NULL},
        {"Events of the twin reach the page, each once", events, begin, finish, NULL},
        {"After a new connection the page gets the events of this connection alone", events_of_another_connection,
         begin, finish, NULL},
        {"SEC: the last 64 events are kept, in messages of bounded size", many_events, begin, finish, NULL},
        {"A reply of several lines reaches the page as one", replies_of_several_lines, begin, finish, NULL},
        {"SEC: lines without end are no reply", too_many_lines, begin, finish, NULL},
        {"A reply that is too long becomes a short one", a_long_reply, begin, finish, NULL},
        {"SEC: a seventeenth request without a reply ends the connection", too_many_requests, begin, finish, NULL},
        {"SEC: the longest message to a page", messages_that_just_fit, begin, finish, NULL},
        {"A page that opens its bus again gets all of it again", a_bus_opened_again, begin, finish, NULL},
        {"A request that is too long for the twin is refused", a_long_request, begin, finish, NULL},
        {"The reason of a twin that reports no changes is shown", a_refused_watch, begin, finish, NULL},
        {"SEC: a page that breaks the rules is closed", rules, begin, finish, NULL},
        {"Signals and values that exceed one message are sent in several", many_signals, begin, finish, NULL},
        {"More signals than a connection watches: the reason is shown", too_many_signals, begin, finish, NULL},
        {"The list has all buses that have described themselves", list_of_buses, begin, finish, NULL},
        {"A bus that was restarted is described again", another_connection, begin, finish, NULL},
        {"SEC: a socket that does not speak the protocol is closed", lines_of_no_twin, begin, finish, NULL},
        {"SEC: bytes that are no UTF-8 become question marks", characters, begin, finish, NULL},
        {"Every change of a plotted signal reaches the pages that plot it", pulses, begin, finish, NULL},
        {"A page that plots again gets the changes since then", a_plot_again, begin, finish, NULL},
        {"SEC: a page that is too late loses the oldest changes", a_late_page, begin, finish, NULL},
        {"SEC: a page plots at most 128 signals, and those of the list", too_many_traces, begin, finish, NULL},
        {"A signal whose name has wildcards is not traced", wildcards, begin, finish, NULL},
        {"Faults that do not fit are omitted from the list", faults_that_do_not_fit, begin, finish, NULL},
        {"The list of faults fits to its last byte", faults_that_just_fit, begin, finish, NULL},
        {"Each reply has all faults, and a line without one adds none", faults_of_each_reply, begin, finish, NULL},
        {"Half a reply ends with its connection", half_a_reply, begin, finish, NULL},
        {"Requests without a reply are refused when their connection ends", requests_of_an_ended_connection, begin,
         finish, NULL},
        {"Half a list ends with its connection", half_a_list, begin, finish, NULL},
        {"The reply of several lines fits to its last byte", lines_that_just_fit, begin, finish, NULL},
        {"A bus is found by its number", buses_by_their_number, begin, finish, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Panel: buses and pages", tests, NULL, NULL);
}
