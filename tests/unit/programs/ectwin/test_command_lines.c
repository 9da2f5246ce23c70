/* SPDX-License-Identifier: MIT */
/* Commands beside a twin: the requests that they send, and the text that they print for each reply. */
#define _GNU_SOURCE
#include "command_lines.h"

/* The longest name that `set` takes. */
#define NAME_50  "a23456789.a23456789.a23456789.a23456789.a23456789."
#define NAME_255 NAME_50 NAME_50 NAME_50 NAME_50 NAME_50 "a2345"

#define OK "{\"ok\":true}\n"
#define NO "{\"ok\":false,\"message\":\"no\"}\n"

static void requests(void **state)
{
    static const command_line_t rows[] = {
        {.line = "get -s ./c.sock a b*",
         .status = 1,
         .text = "ectwin get: no\nectwin get: no\n",
         .replies = {NO, NO},
         .requests =
             "{\"op\":\"get\",\"slave\":1,\"pattern\":\"a\"}\n{\"op\":\"get\",\"slave\":1,\"pattern\":\"b*\"}\n"},
        {.line = "get -s ./c.sock -n 2 a",
         .status = 1,
         .text = "ectwin get: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"get\",\"slave\":2,\"pattern\":\"a\"}\n"},
        {.line = "get -s ./c.sock -n t a",
         .status = 1,
         .text = "ectwin get: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"get\",\"slave\":\"t\",\"pattern\":\"a\"}\n"},
        {.line = "get -s ./c.sock -n 0x10 a",
         .status = 1,
         .text = "ectwin get: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"get\",\"slave\":16,\"pattern\":\"a\"}\n"},
        {.line = "list-signals -s ./c.sock -n 3 a",
         .status = 1,
         .text = "ectwin list-signals: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"list\",\"slave\":3,\"pattern\":\"a\"}\n"},
        {.line = "set -s ./c.sock a=1 b=x=y c=",
         .status = 1,
         .text = "ectwin set: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\",\"b\":\"x=y\",\"c\":\"\"}}\n"},
        {.line = "set -s ./c.sock " NAME_255 "=1",
         .status = 1,
         .text = "ectwin set: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"" NAME_255 "\":\"1\"}}\n"},
        {.line = "set -s ./c.sock " NAME_255 "x=1",
         .status = 1,
         .text = "ectwin set: '" NAME_255 "x=1' is not NAME=VALUE\n",
         .replies = {NO},
         .requests = ""},
        {.line = "set -s ./c.sock -n 2 a=1",
         .status = 1,
         .text = "ectwin set: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":2,\"values\":{\"a\":\"1\"}}\n"},
        {.line = "set -s ./c.sock -n t a=1 --at 2.5s",
         .status = 1,
         .text = "ectwin set: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":\"t\",\"values\":{\"a\":\"1\"},\"at\":2.5}\n"},
        {.line = "set -s ./c.sock a=1 --at 0s",
         .status = 1,
         .text = "ectwin set: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\"},\"at\":0}\n"},
        {.line = "command -s ./c.sock ru1 00",
         .status = 1,
         .text = "ectwin command: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"ru1.command\":\"00\"}}\n"},
        {.line = "command -s ./c.sock -n 2 ru1 00",
         .status = 1,
         .text = "ectwin command: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"set\",\"slave\":2,\"values\":{\"ru1.command\":\"00\"}}\n"},
        {.line = "fault -s ./c.sock",
         .status = 1,
         .text = "ectwin fault: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"fault\"}\n"},
        {.line = "fault -s ./c.sock hang slave 1",
         .status = 1,
         .text = "ectwin fault: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"fault\",\"fault\":\"hang slave 1\"}\n"},
        {.line = "fault -s ./c.sock 'drop 5%'",
         .status = 1,
         .text = "ectwin fault: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"fault\",\"fault\":\"drop 5%\"}\n"},
        {.line = "unplug -s ./c.sock 2",
         .status = 1,
         .text = "ectwin unplug: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_in\":0,\"ecat.plug_out\":0,\"ecat.plug_2\":0,\"ecat.plug_3\":0},\"op\":"
                     "\"set\",\"slave\":2}\n"},
        {.line = "plug -s ./c.sock t",
         .status = 1,
         .text = "ectwin plug: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_in\":1,\"ecat.plug_out\":1,\"ecat.plug_2\":1,\"ecat.plug_3\":1},\"op\":"
                     "\"set\",\"slave\":\"t\"}\n"},
        {.line = "unplug -s ./c.sock alias:7",
         .status = 1,
         .text = "ectwin unplug: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_in\":0,\"ecat.plug_out\":0,\"ecat.plug_2\":0,\"ecat.plug_3\":0},\"op\":"
                     "\"set\",\"slave\":\"alias:7\"}\n"},
        {.line = "cut -s ./c.sock 2.0",
         .status = 1,
         .text = "ectwin cut: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_in\":0},\"op\":\"set\",\"slave\":2}\n"},
        {.line = "cut -s ./c.sock t.3",
         .status = 1,
         .text = "ectwin cut: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_3\":0},\"op\":\"set\",\"slave\":\"t\"}\n"},
        {.line = "mend -s ./c.sock 1.1",
         .status = 1,
         .text = "ectwin mend: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_out\":1},\"op\":\"set\",\"slave\":1}\n"},
        {.line = "mend -s ./c.sock alias:65535.2",
         .status = 1,
         .text = "ectwin mend: no\n",
         .replies = {NO},
         .requests = "{\"values\":{\"ecat.plug_2\":1},\"op\":\"set\",\"slave\":\"alias:65535\"}\n"},
        {.line = "stats -s ./c.sock",
         .status = 1,
         .text = "ectwin stats: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"stats\"}\n"},
        {.line = "watch -s ./c.sock -n 2 a b",
         .status = 1,
         .text = "ectwin watch: no\nectwin watch: no\n",
         .replies = {NO, NO},
         .requests =
             "{\"op\":\"watch\",\"slave\":2,\"pattern\":\"a\"}\n{\"op\":\"watch\",\"slave\":2,\"pattern\":\"b\"}\n"},
        {.line = "watch -s ./c.sock --every a",
         .status = 1,
         .text = "ectwin watch: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\",\"every\":true}\n"},
        {.line = "watch -s ./c.sock --every --until x=1",
         .status = 1,
         .text = "ectwin watch: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"x\",\"every\":true}\n"},
        {.line = "wait -s ./c.sock a=1",
         .status = 1,
         .text = "ectwin wait: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\",\"every\":true}\n"},
        {.line = "wait -s ./c.sock -n 2 a.b=1",
         .status = 1,
         .text = "ectwin wait: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"watch\",\"slave\":2,\"pattern\":\"a.b\",\"every\":true}\n"},
        {.line = "wait -s ./c.sock -n t a=1",
         .status = 1,
         .text = "ectwin wait: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"watch\",\"slave\":\"t\",\"pattern\":\"a\",\"every\":true}\n"},
        {.line = "periodic -s ./c.sock -n 3",
         .status = 1,
         .text = "ectwin periodic: no\n",
         .replies = {NO},
         .requests = "{\"op\":\"data\",\"slave\":3,\"offset\":0}\n"},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

static void values(void **state)
{
    static const command_line_t rows[] = {
        {.line = "get -s ./c.sock", .text = "a=0\n", .replies = {"{\"name\":\"a\",\"value\":0}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=-1\n", .replies = {"{\"name\":\"a\",\"value\":-1}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=1.5\n", .replies = {"{\"name\":\"a\",\"value\":1.5}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=123456789012345\n",
         .replies = {"{\"name\":\"a\",\"value\":123456789012345}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=-12345678901234\n",
         .replies = {"{\"name\":\"a\",\"value\":-12345678901234}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=1234567890123456\n",
         .replies = {"{\"name\":\"a\",\"value\":1234567890123456}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=-123456789012345\n",
         .replies = {"{\"name\":\"a\",\"value\":-123456789012345}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=12345678901234567890\n",
         .replies = {"{\"name\":\"a\",\"value\":12345678901234567890}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=1.23456789012346e+15\n",
         .replies = {"{\"name\":\"a\",\"value\":1234567890123456.5}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=1e+20\n", .replies = {"{\"name\":\"a\",\"value\":1e20}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=1e-07\n", .replies = {"{\"name\":\"a\",\"value\":1e-7}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=0.1\n", .replies = {"{\"name\":\"a\",\"value\":0.1}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=\n", .replies = {"{\"name\":\"a\",\"value\":true}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=\n", .replies = {"{\"name\":\"a\",\"value\":null}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=\n", .replies = {"{\"name\":\"a\",\"value\":\"\"}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=1234567890123456\n",
         .replies = {"{\"name\":\"a\",\"value\":\"1234567890123456\"}\n" OK}},
        {.line = "get -s ./c.sock", .text = "a=\n", .replies = {"{\"name\":\"a\",\"value\":[1]}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=1234567890123456\n",
         .replies = {"{\"value\":1234567890123456,\"name\":\"a\"}\n" OK}},
        {.line = "get -s ./c.sock",
         .text = "a=1\n=\n=\nb=2\n",
         .replies = {"{\"name\":\"a\",\"value\":1}\nnonsense\n{\"ok\":1}\n{\"name\":\"b\",\"value\":2}\n" OK}},
        {.line = "get -s ./c.sock", .status = 1, .text = "ectwin get: \n", .replies = {"{\"ok\":false}\n"}},
        {.line = "get -s ./c.sock",
         .status = 1,
         .text = "ectwin get: 7\n",
         .replies = {"{\"ok\":false,\"message\":7}\n"}},
        {.line = "get -s ./c.sock a b",
         .status = 1,
         .text = "ectwin get: no\na=1\nb=2\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" NO, "{\"name\":\"b\",\"value\":2}\n" OK}},
        {.line = "get -s ./c.sock a b",
         .status = 1,
         .text = "ectwin get: no\na=1\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK, NO}},
        {.line = "get -s ./c.sock a b",
         .status = 3,
         .text = "ectwin get: the twin has ended, or has closed this connection\na=1\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n"}},
        {.line = "get -s ./c.sock t.a",
         .text = "t.a=1\n",
         .replies = {"{\"name\":\"a\",\"twin\":\"t\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "get -s ./c.sock t.a",
         .text = "a=1\n",
         .replies = {"{\"name\":\"a\",\"twin\":\"\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "get -s ./c.sock ta",
         .text = "a=1\n",
         .replies = {"{\"name\":\"a\",\"twin\":\"t\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "get -s ./c.sock s.a",
         .text = "a=1\n",
         .replies = {"{\"name\":\"a\",\"twin\":\"t\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "get -s ./c.sock -n 00",
         .text = "1:a=1\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

static void conditions(void **state)
{
    static const command_line_t rows[] = {
        {.line = "wait -s ./c.sock a=1", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock a=1", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1.0}\n" OK}},
        {.line = "wait -s ./c.sock a=1.0", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock a=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":2}\n" OK}},
        {.line = "wait -s ./c.sock a!=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock a!=1", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":2}\n" OK}},
        {.line = "wait -s ./c.sock a!=x", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":2}\n" OK}},
        {.line = "wait -s ./c.sock a<2", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock a<2",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":2}\n" OK}},
        {.line = "wait -s ./c.sock a>2",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":2}\n" OK}},
        {.line = "wait -s ./c.sock a>2", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":3}\n" OK}},
        {.line = "wait -s ./c.sock a=x",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock a=1", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"1\"}\n" OK}},
        {.line = "wait -s ./c.sock a=x", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"x\"}\n" OK}},
        {.line = "wait -s ./c.sock a=x",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"y\"}\n" OK}},
        {.line = "wait -s ./c.sock a!=x",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"x\"}\n" OK}},
        {.line = "wait -s ./c.sock a!=x", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"y\"}\n" OK}},
        {.line = "wait -s ./c.sock a<2",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"1\"}\n" OK}},
        {.line = "wait -s ./c.sock a>2",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"3\"}\n" OK}},
        {.line = "wait -s ./c.sock a=", .text = "", .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"\"}\n" OK}},
        {.line = "wait -s ./c.sock a=",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":0}\n" OK}},
        {.line = "wait -s ./c.sock a=1=2",
         .text = "",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":\"1=2\"}\n" OK}},
        {.line = "wait -s ./c.sock b=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock -n 01 a=1",
         .text = "",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock -n 0x1 a=1",
         .text = "",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock -n 2 a=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock -n t a=1",
         .text = "",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"twin\":\"t\",\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock -n u a=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"twin\":\"t\",\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock t.a=1",
         .text = "",
         .replies = {"{\"name\":\"a\",\"slave\":2,\"twin\":\"t\",\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock u.a=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":2,\"twin\":\"t\",\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock t.a=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":2,\"value\":1}\n" OK}},
        {.line = "wait -s ./c.sock a=1",
         .status = 3,
         .text = "ectwin wait: the twin has ended, or has closed this connection\n",
         .replies = {"{\"name\":\"a\",\"slave\":1}\n" OK}},
        {.line = "wait -s ./c.sock a*=1",
         .status = 1,
         .text = "ectwin wait: 'a*=1': a condition is on one signal: its name has no '*', '?' or '['\n",
         .replies = {OK}},
        {.line = "wait -s ./c.sock a?=1",
         .status = 1,
         .text = "ectwin wait: 'a?=1': a condition is on one signal: its name has no '*', '?' or '['\n",
         .replies = {OK}},
        {.line = "wait -s ./c.sock a[=1",
         .status = 1,
         .text = "ectwin wait: 'a[=1': a condition is on one signal: its name has no '*', '?' or '['\n",
         .replies = {OK}},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

static void watch(void **state)
{
    static const command_line_t rows[] = {
        {.line = "watch -s ./c.sock",
         .status = 3,
         .text = "ectwin watch: the twin has ended, or has closed this "
                 "connection\n{\"name\":\"a\",\"slave\":1,\"value\":1}\n{\"name\":\"a\",\"slave\":1,\"value\":2}\n",
         .replies =
             {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n{\"ok\":true}\n{\"name\":\"a\",\"slave\":1,\"value\":2}\n"}},
        {.line = "watch -s ./c.sock a b",
         .status = 3,
         .text = "ectwin watch: the twin has ended, or has closed this "
                 "connection\n{\"name\":\"a\",\"slave\":1,\"value\":1}\n{\"name\":\"b\",\"slave\":1,\"value\":5}\n{"
                 "\"name\":\"b\",\"slave\":1,\"value\":6}\n",
         .replies =
             {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK,
              "{\"name\":\"b\",\"slave\":1,\"value\":5}\n{\"ok\":true}\n{\"name\":\"b\",\"slave\":1,\"value\":6}\n"}},
        {.line = "watch -s ./c.sock a b",
         .status = 1,
         .text = "ectwin watch: no\n{\"name\":\"a\",\"slave\":1,\"value\":1}\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" NO, OK}},
        {.line = "watch -s ./c.sock --until a=1",
         .text = "{\"name\":\"a\",\"slave\":1,\"value\":1}\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK}},
        {.line = "watch -s ./c.sock --until a=2",
         .text = "{\"name\":\"a\",\"slave\":1,\"value\":1}\n{\"name\":\"a\",\"slave\":1,\"value\":2}\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n{\"ok\":true}\n{\"name\":\"a\",\"slave\":1,\"value\":2}"
                     "\n{\"name\":\"a\",\"slave\":1,\"value\":3}\n"}},
        {.line = "watch -s ./c.sock --until a=2 b",
         .text = "{\"name\":\"a\",\"slave\":1,\"value\":1}\n{\"name\":\"b\",\"slave\":1,\"value\":5}\n{\"name\":\"a\","
                 "\"slave\":1,\"value\":2}\n",
         .replies =
             {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" OK,
              "{\"name\":\"b\",\"slave\":1,\"value\":5}\n{\"ok\":true}\n{\"name\":\"a\",\"slave\":1,\"value\":2}\n"},
         .requests =
             "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\"}\n{\"op\":\"watch\",\"slave\":1,\"pattern\":\"b\"}\n"},
        {.line = "watch -s ./c.sock --until a=2 b",
         .status = 1,
         .text = "ectwin watch: no\n{\"name\":\"a\",\"slave\":1,\"value\":1}\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1}\n" NO, OK},
         .requests = "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\"}\n"},
        {.line = "watch -s ./c.sock -n 0 --until a=2 b",
         .text = "{\"name\":\"a\",\"slave\":7,\"value\":2}\n",
         .replies = {"{\"name\":\"a\",\"slave\":7,\"value\":2}\n" OK},
         .requests = "{\"op\":\"watch\",\"slave\":0,\"pattern\":\"a\"}\n"},
        {.line = "watch -s ./c.sock -n 00 --until a=2 b",
         .text = "{\"name\":\"a\",\"slave\":7,\"value\":2}\n",
         .replies = {"{\"name\":\"a\",\"slave\":7,\"value\":2}\n" OK},
         .requests = "{\"op\":\"watch\",\"slave\":0,\"pattern\":\"a\"}\n"},
        {.line = "watch -s ./c.sock --csv - --until a=2 a",
         .text = "time,a\n0.000000,1\n2.500000,2\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1,\"time\":1.5}\n{\"ok\":true}\n{\"name\":\"a\",\"slave\":"
                     "1,\"value\":2,\"time\":4}\n"},
         .requests = "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\"}\n"},
        {.line = "watch -s ./c.sock --csv - --until a=1 a",
         .text = "time,a\n0.000000,1\n",
         .replies = {"{\"name\":\"a\",\"slave\":1,\"value\":1,\"time\":1.5}\n" OK},
         .requests = "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"a\"}\n"},
        {.line = "watch -s ./c.sock --csv - t.a a",
         .status = 3,
         .text = "ectwin watch: the twin has ended, or has closed this "
                 "connection\ntime,t.a,a\n0.000000,1,2\n0.250000,,3\n1.000000,4,\n",
         .replies =
             {"{\"name\":\"a\",\"slave\":1,\"twin\":\"t\",\"value\":1,\"time\":1}\n" OK,
              "{\"name\":\"a\",\"slave\":2,\"twin\":\"u\",\"value\":2,\"time\":1}\n{\"ok\":true}\n{\"name\":\"a\","
              "\"slave\":2,\"twin\":\"u\",\"value\":3,\"time\":1.25}\n{\"name\":\"a\",\"slave\":1,\"twin\":\"t\","
              "\"value\":4,\"time\":2}\n{\"name\":\"a\",\"slave\":3,\"twin\":\"v\",\"value\":5,\"time\":3}\n"}},
        {.line = "watch -s ./c.sock --csv - a", .status = 1, .text = "ectwin watch: no\n", .replies = {NO}},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

static void tables(void **state)
{
    static const command_line_t rows[] = {
        {.line = "set -s ./c.sock --csv t.csv",
         .text = "",
         .replies = {OK, OK, OK},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\",\"b\":\"2\"}}\n",
         .table = "a,b\n1,2\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .text = "",
         .replies = {OK, OK, OK},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\"}}\n{\"op\":\"set\",\"slave\":1,\"values\":{"
                     "\"b\":\"2\"}}\n",
         .table = "a,b\n1,\n,2\n,\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .status = 1,
         .text = "ectwin set: line 2 of 't.csv': no line with values follows\n",
         .replies = {OK, OK, OK},
         .requests = "",
         .table = "a\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .status = 1,
         .text = "ectwin set: cannot read 't.csv': it is empty\n",
         .replies = {OK, OK, OK},
         .requests = "",
         .table = ""},
        {.line = "set -s ./c.sock --csv t.csv",
         .status = 1,
         .text =
             "ectwin set: line 2 of 't.csv': its number of cells differs from the number of names in the first line\n",
         .replies = {OK, OK, OK},
         .requests = "",
         .table = "a,b\n1\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .text = "",
         .replies = {OK, OK, OK},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\"}}\n{\"op\":\"set\",\"slave\":1,\"values\":{"
                     "\"a\":\"2\"}}\n",
         .table = "time,a\n0,1\n0,2\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .status = 1,
         .text = "ectwin set: line 2 of 't.csv': its time is not a number of seconds, 0 or more\n",
         .replies = {OK, OK, OK},
         .requests = "",
         .table = "time,a\nx,1\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .text = "",
         .replies = {OK, OK, OK},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\"}}\n",
         .table = "a,time\n1,0\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .status = 1,
         .text = "ectwin set: line 3 of 't.csv': its time is before that of the line above\n",
         .replies = {OK, OK, OK},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\"}}\n",
         .table = "time,a\n0.02,1\n0.01,2\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .text = "",
         .replies = {OK, OK, OK},
         .requests = "",
         .table = "time,a\n0,\n"},
        {.line = "set -s ./c.sock x=1 --csv t.csv",
         .text = "",
         .replies = {OK, OK, OK},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"x\":\"1\"}}\n{\"op\":\"set\",\"slave\":1,\"values\":{"
                     "\"a\":\"1\"}}\n",
         .table = "a\n1\n"},
        {.line = "set -s ./c.sock x=1 --csv t.csv",
         .status = 1,
         .text = "ectwin set: no\n",
         .replies = {NO, NO, NO},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"x\":\"1\"}}\n",
         .table = "a\n1\n"},
        {.line = "set -s ./c.sock --csv t.csv",
         .status = 1,
         .text = "ectwin set: no\nectwin set: line 3 of 't.csv': refused; the lines before it are set\n",
         .replies = {OK, NO},
         .requests = "{\"op\":\"set\",\"slave\":1,\"values\":{\"a\":\"1\"}}\n{\"op\":\"set\",\"slave\":1,\"values\":{"
                     "\"a\":\"2\"}}\n",
         .table = "a\n1\n2\n3\n"},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

static void sets(void **state)
{
    static const command_line_t rows[] = {
        {.line = "periodic -s ./c.sock",
         .text = "00000  00 01 7f                                         ...\n",
         .replies = {"{\"serial\":1,\"size\":3,\"offset\":0,\"data\":\"0001\"}\n" OK,
                     "{\"serial\":1,\"size\":3,\"offset\":2,\"data\":\"7f\"}\n" OK},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n{\"op\":\"data\",\"slave\":1,\"offset\":2}\n"},
        {.line = "periodic -s ./c.sock",
         .text = "00000  1f 20 7e 7f 41 41 41 41 41 41 41 41 41 41 41 41  . ~.AAAAAAAAAAAA\n00010  41                  "
                 "                             A\n",
         .replies = {"{\"serial\":1,\"size\":17,\"offset\":0,\"data\":\"1f207e7f41414141414141414141414141\"}\n" OK},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n"},
        {.line = "periodic -s ./c.sock",
         .text = "00000  00 01 02                                         ...\n",
         .replies = {"{\"serial\":1,\"size\":3,\"offset\":0,\"data\":\"0001\"}\n" OK,
                     "{\"serial\":1,\"size\":3,\"offset\":1,\"data\":\"ff\"}\n" OK,
                     "{\"serial\":1,\"size\":3,\"offset\":2,\"data\":\"02\"}\n" OK},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n{\"op\":\"data\",\"slave\":1,\"offset\":2}\n{\"op\":"
                     "\"data\",\"slave\":1,\"offset\":2}\n"},
        {.line = "periodic -s ./c.sock",
         .text = "00000  41 42 43                                         ABC\n",
         .replies = {"{\"serial\":1,\"size\":3,\"offset\":0,\"data\":\"4142434\"}\n" OK},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n"},
        {.line = "periodic -s ./c.sock",
         .status = 1,
         .text = "ectwin periodic: no\n",
         .replies = {"{\"serial\":1,\"size\":51200,\"offset\":0,\"data\":\"\"}\n" OK, NO},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n{\"op\":\"data\",\"slave\":1,\"offset\":0}\n"},
        {.line = "periodic -s ./c.sock",
         .text = "00000  42                                               B\n",
         .replies = {"{\"serial\":1,\"size\":51201,\"offset\":0,\"data\":\"41\"}\n" OK,
                     "{\"serial\":2,\"size\":1,\"offset\":0,\"data\":\"42\"}\n" OK},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n{\"op\":\"data\",\"slave\":1,\"offset\":0}\n"},
        {.line = "periodic -s ./c.sock",
         .text = "00000  42                                               B\n",
         .replies = {"{\"serial\":1,\"offset\":0,\"data\":\"41\"}\n" OK,
                     "{\"serial\":2,\"size\":1,\"offset\":0,\"data\":\"42\"}\n" OK},
         .requests = "{\"op\":\"data\",\"slave\":1,\"offset\":0}\n{\"op\":\"data\",\"slave\":1,\"offset\":0}\n"},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

static void lists(void **state)
{
    static const command_line_t rows[] = {
        {.line = "fault -s ./c.sock",
         .text = "drop 5%\nx\\x1b\n",
         .replies = {"{\"fault\":\"drop 5%\"}\n{\"fault\":\"x\\u001b\"}\n" OK}},
        {.line = "fault -s ./c.sock "
                 "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa b",
         .status = 1,
         .text = "ectwin fault: a fault is at most 95 characters long\n",
         .replies = {OK}},
        {.line = "fault -s ./c.sock "
                 "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa b",
         .status = 1,
         .text = "ectwin fault: no\n",
         .replies = {NO},
         .requests =
             "{\"op\":\"fault\",\"fault\":"
             "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa b\"}\n"},
        {.line = "fault -s ./c.sock "
                 "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
         .status = 1,
         .text = "ectwin fault: no\n",
         .replies = {NO},
         .requests =
             "{\"op\":\"fault\",\"fault\":"
             "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\"}\n"},
        {.line = "fault -s ./c.sock "
                 "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
         .status = 1,
         .text = "ectwin fault: a fault is at most 95 characters long\n",
         .replies = {NO},
         .requests = ""},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

#define BAR_25 "#########################"

/* Bars of a histogram: the longest has 50 characters; steps before the first answer and behind the last are left out.
 */
static void histograms(void **state)
{
    static const command_line_t rows[] = {
        {.line = "stats -s ./c.sock",
         .text = "   <       1 us            1  " BAR_25 BAR_25 "\n   <       2 us            1  " BAR_25 BAR_25 "\n",
         .replies = {"{\"answers\":[1,1,0],\"edges_us\":[1,2]}\n" OK}},
        {.line = "stats -s ./c.sock",
         .text = "   <       2 us            1  " BAR_25 "\n       longer             2  " BAR_25 BAR_25 "\n",
         .replies = {"{\"answers\":[0,1,2],\"edges_us\":[1,2]}\n" OK}},
        {.line = "stats -s ./c.sock",
         .text = "   <       1 us            2  " BAR_25 BAR_25
                 "\n   <       2 us            0  \n       longer             1  " BAR_25 "\n",
         .replies = {"{\"answers\":[2,0,1],\"edges_us\":[1,2]}\n" OK}},
        {.line = "stats -s ./c.sock", .text = "", .replies = {"{\"answers\":[0,0],\"edges_us\":[1]}\n" OK}},
        {.line = "stats -s ./c.sock", .text = "", .replies = {"{\"answers\":[],\"edges_us\":[]}\n" OK}},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

/* The words of a bus, its signals and its script become a file. The values of data1, data2, ... are 0 at the start. */
static void saves(void **state)
{
    static const command_line_t rows[] = {
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nfault:\n  - a\n  - z\n  - A\n  - Z\n  - 0\n  - 9\n  - /\n  - '`'\n  - '{'\n  - '@'\n  - "
                 "'['\n  - ':'\n  - 'b:'\n  - 'b''c'\n  - '-'\n  - 'a b'\n  - a_b./+:#=-c\n  - '~'\n  - 'a%'\ntwins:\n "
                 " - device: fzm1\n",
         .replies = {"{\"data\":\"2f7800667a6d3100\"}\n" OK, OK, OK,
                     "{\"line\":\"a\"}\n{\"line\":\"z\"}\n{\"line\":\"A\"}\n{\"line\":\"Z\"}\n{\"line\":\"0\"}\n{"
                     "\"line\":\"9\"}\n{\"line\":\"/"
                     "\"}\n{\"line\":\"`\"}\n{\"line\":\"{\"}\n{\"line\":\"@\"}\n{\"line\":\"[\"}\n{\"line\":\":\"}\n{"
                     "\"line\":\"b:\"}\n{\"line\":\"b'c\"}\n{\"line\":\"-\"}\n{\"line\":\"a "
                     "b\"}\n{\"line\":\"a_b./+:#=-c\"}\n{\"line\":\"~\"}\n{\"line\":\"a%\"}\n" OK,
                     OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\ntwins:\n  - device: fzm1\n    set:\n      data1: 5\n      comment1: 'x y'\n      data8: "
                 "'-1.5'\n",
         .replies = {"{\"data\":\"2f7800667a6d3100\"}\n" OK, OK,
                     "{\"slave\":1,\"name\":\"data1\",\"value\":5,\"access\":\"rw\"}\n{\"slave\":1,\"name\":\"data2\","
                     "\"value\":0,\"access\":\"rw\"}\n{\"slave\":1,\"name\":\"data3\",\"value\":6,\"access\":\"r\"}\n{"
                     "\"slave\":1,\"name\":\"data4\",\"access\":\"rw\",\"value\":null}\n{\"slave\":0,\"name\":"
                     "\"data5\",\"value\":5,\"access\":\"rw\"}\n{\"slave\":2,\"name\":\"data5\",\"value\":5,\"access\":"
                     "\"rw\"}\n{\"slave\":1,\"name\":\"nosuch\",\"value\":5,\"access\":\"rw\"}\n{\"name\":\"data6\","
                     "\"value\":5,\"access\":\"rw\"}\n{\"slave\":1,\"value\":5,\"access\":\"rw\"}\n{\"slave\":1,"
                     "\"name\":\"data7\",\"value\":5}\n{\"slave\":1,\"name\":\"comment1\",\"value\":\"x "
                     "y\",\"access\":\"rw\"}\n{\"slave\":1,\"name\":\"data8\",\"value\":-1.5,\"access\":\"rw\"}\n" OK,
                     OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nset:\n  - 1:data1=5\n  - 2:data1=6\ntwins:\n  - device: fzm1\n    count: 2\n  - device: "
                 "fzm1\n    name: a\n    set:\n      data1: 7\n",
         .replies = {"{\"data\":\"2f7800667a6d312a322c613d667a6d3100\"}\n" OK, OK,
                     "{\"slave\":1,\"name\":\"data1\",\"value\":5,\"access\":\"rw\"}\n{\"slave\":2,\"name\":\"data1\","
                     "\"value\":6,\"access\":\"rw\"}\n{\"slave\":3,\"name\":\"data1\",\"value\":7,\"access\":\"rw\"}\n{"
                     "\"slave\":4,\"name\":\"data1\",\"value\":8,\"access\":\"rw\"}\n" OK,
                     OK}},
        {.line = "save-bus -s ./c.sock",
         .status = 3,
         .text = "ectwin save-bus: slave 1: 'data1=x' is left out, a bus refuses it at its start: data1 takes "
                 "-999999999..999999999, not 'x'\nectwin: 1\ntwins:\n  - device: fzm1\n    set:\n      data2: 1\n",
         .replies = {"{\"data\":\"2f7800667a6d3100\"}\n" OK, OK,
                     "{\"slave\":1,\"name\":\"data1\",\"value\":\"x\",\"access\":\"rw\"}\n{\"slave\":1,\"name\":"
                     "\"data2\",\"value\":1,\"access\":\"rw\"}\n" OK,
                     OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nrealtime: 70\nbusy-poll: true\ntwins:\n  - device: fzm1\n",
         .replies = {"{\"data\":\"2f78002d2d7265616c74696d65003730002d2d627573792d706f6c6c00667a6d3100\"}\n" OK, OK, OK,
                     OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nrealtime: 50\ntwins:\n  - device: fzm1\n",
         .replies = {"{\"data\":\"2f78002d2d7265616c74696d6500667a6d3100\"}\n" OK, OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nrealtime: 70\ntwins:\n  - device: fzm1\n",
         .replies = {"{\"data\":\"2f78002d2d7265616c74696d653d373000667a6d3100\"}\n" OK, OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nalias:\n  - 1:5\n  - 2:6\n  - 3:7\ntwins:\n  - device: fzm1\n    count: 3\n",
         .replies =
             {"{\"data\":"
              "\"2f78002d2d616c69617300313a35002d2d616c69617300323a36002d2d616c69617300333a3700667a6d312a3300\"}\n" OK,
              OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nkeep-source-mac: true\nseed: 4\ntwins:\n  - device: fzm1\n",
         .replies = {"{\"data\":"
                     "\"2f78002d2d6b6565702d736f757263652d6d6163002d2d6b6565702d736f757263652d6d6163002d2d7365656400340"
                     "0667a6d3100\"}\n" OK,
                     OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nquiet: true\ntwins:\n  - device: fzm1\n",
         .replies = {"{\"data\":"
                     "\"2f78002d2d7365740064617461313d35002d2d6661756c740064726f70203525002d2d64726f700033002d2d7175696"
                     "574002d690065746830002d6f006574683100667a6d3100\"}\n" OK,
                     OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .status = 1,
         .text =
             "ectwin save-bus: there is no device 'true'; there are: vr-bu-ect-map1, vr-bu-ect-map3, vr-bu-ect-map7, "
             "vr-bu-ect-multiarm, fzm1, optoncdt2300, pmctendo-dd5, esi:FILE.xml#TYPE, sii:FILE and yaml:FILE\n",
         .replies = {"{\"data\":"
                     "\"2f78002d2d6966616365006d30002d2d696e2d70726f63657373002d2d7669727475616c2d74696d65002d2d6c65617"
                     "6652d6368696c6472656e00667a6d31002d2d007472756500\"}\n" OK,
                     OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .status = 3,
         .text = "ectwin save-bus: '--store=/x/s' is left out, a bus file writes only below its own folder: give it on "
                 "the command line, or the file a place above it by -o FILE\nectwin: 1\nplay: /x/p.csv\ntwins:\n  - "
                 "device: fzm1\n",
         .replies = {"{\"data\":\"2f78002d2d73746f72650073002d2d706c617900702e63737600667a6d3100\"}\n" OK, OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .text = "ectwin: 1\nname: n\ntwins:\n  - device: fzm1\n",
         .replies = {"{\"data\":\"2f78002d2d6e616d65006e00667a6d31\"}\n" OK, OK, OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .status = 3,
         .text = "ectwin save-bus: the bus has no command line, or there is not enough memory for it\n",
         .replies = {OK, OK}},
        {.line = "save-bus -s ./c.sock",
         .status = 1,
         .text = "ectwin save-bus: no\n",
         .replies = {"{\"data\":\"2f7800667a6d3100\"}\n" OK, OK, NO},
         .requests =
             "{\"op\":\"words\",\"offset\":0}\n{\"op\":\"words\",\"offset\":8}\n{\"op\":\"list\",\"slave\":0}\n"},
        {.line = "save-bus -s ./c.sock",
         .status = 1,
         .text = "ectwin save-bus: no\n",
         .replies = {"{\"data\":\"2f7800667a6d3100\"}\n" OK, OK, OK, NO},
         .requests = "{\"op\":\"words\",\"offset\":0}\n{\"op\":\"words\",\"offset\":8}\n{\"op\":\"list\",\"slave\":0}"
                     "\n{\"op\":\"script\",\"offset\":0}\n"},
    };
    (void)state;
    COMMANDS_EXPECT(rows);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("each command sends its request", requests),
        TEST("values are printed as the twin sends them; integers keep all digits", values),
        TEST("a condition is met by a line of its signal and slave", conditions),
        TEST("lines of signals are printed or recorded, and end the command", watch),
        TEST("each line of a table is a request; a wrong line ends the command", tables),
        TEST("a set of periodic data arrives in pieces, each at its offset", sets),
        TEST("a bus is saved with its options, signals and script", saves),
        TEST("a histogram has bars from the first answer to the last", histograms),
        TEST("a fault has at most 95 characters", lists),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Commands beside a twin", tests, commands_begin, commands_end);
}
