/* SPDX-License-Identifier: MIT */
/* Device files whose objects are a table: the objects that its lines stand for, and the line that refuses one. */
#define _GNU_SOURCE
#include "devfile_made.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { TEXT = 500 };

#define DEVICE "ectwin-device: 1\nvendor: {id: 0xE57, name: Works}\nproduct: 0x101\ntype: G-1\nobjects: o.csv\n"

static char folder[] = "/tmp/ectwin-table-XXXXXX";
static char table_path[64], device_path[64];

static void write_table(const char *csv, size_t length)
{
    FILE *file = fopen(table_path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(csv, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
}

static made_t try_device(const char *yaml, const char *csv)
{
    write_table(csv, strlen(csv));
    return made_of(device_path, yaml);
}

static made_t make(const char *yaml, const char *csv)
{
    return whole("the table", try_device(yaml, csv));
}

static void a_line_is_an_entry_of_an_object(void **state)
{
    (void)state;
    made_t m = make(DEVICE, "index,subindex,object,name,type,access,default,min,max,unit,pdo,bits,values,backup\n"
                            "0x6000,,,Distance,DINT,,,-5,5,um,in,,,\n"
                            "0x7000,1,Axis,Command,USINT,,,,,,out,\"0=ON;4-7=GEAR\",,\n"
                            "0x7000,2,,Mode,USINT,,1,,,,out,,\"0=OFF, 1=ON\",\n"
                            "\n0x8000,0,,Name,STRING(4),rw,abc,,,,,,,true\n");
    ect_od_t od = ect_device_od(ect_esi_twin_product(m.twin)->device, NULL);
    const ect_detail_t *detail = ect_od_detail(&od, 0x6000, 0);
    assert_non_null(detail);
    assert_true(detail->minimum == -5 && detail->maximum == 5 && detail->unit == 0xFA01);
    assert_int_equal(entry_of(&m, 0x6000, 0)->access, ECT_ACCESS_RO | ECT_ACCESS_TXPDO);
    assert_string_equal(ect_od_find(&od, 0x7000)->name, "Axis");
    assert_int_equal(ect_od_find(&od, 0x7000)->object_code, ECT_OBJECT_RECORD);
    assert_int_equal(entry_of(&m, 0x7000, 1)->access, ECT_ACCESS_RW | ECT_ACCESS_RXPDO);
    assert_int_equal(entry_of(&m, 0x7000, 2)->value, 1);
    assert_int_equal(ect_od_detail(&od, 0x7000, 2)->maximum, 1);
    assert_int_equal(entry_of(&m, 0x8000, 0)->access, ECT_ACCESS_RW | ECT_ACCESS_BACKUP);
    assert_int_equal(ect_od_element(ect_od_find(&od, 0x1A00), 1), 0x60000020);
    assert_int_equal(ect_od_element(ect_od_find(&od, 0x1600), 2), 0x70000208);
    const ect_field_t *f = ect_esi_twin_product(m.twin)->plant->fields;
    assert_true(f[0].index == 0x7000 && f[0].width == 1 && f[1].bit == 4 && f[1].width == 4);
    assert_true(f[2].subindex == 2 && f[2].values[1].value == 1 && f[3].index == 0);
    drop(&m);
}

static void tables_of_office_programs_are_read(void **state)
{
    (void)state;
    made_t m = make(DEVICE "inputs: [0x6000]\n", "\xEF\xBB\xBFindex;name;type\r\n0x6000;\"A; B\";INT\r\n");
    assert_string_equal(entry_of(&m, 0x6000, 0)->name, "A; B");
    drop(&m);
}

static void a_wrong_table_is_refused_with_its_line_and_a_cure(void **state)
{
    static const struct {
        const char *csv, *why; /* behind the folder */
    } rows[] = {
        {"", "o.csv:1: it is empty"},
        {"index,name\n", "o.csv:1: the column 'type' is missing: the first line has the names of the columns"},
        {"index,name,type,colour\n", "o.csv:1: 'colour' is no column, or occurs twice: index, subindex, object"},
        {"index,name,type,name\n", "o.csv:1: 'name' is no column, or occurs twice"},
        {"index,name,type\n0x6000,A\n",
         "o.csv:2: its number of cells differs from the number of names in the first line"},
        {"index,name,type\n0x60,A,INT\n", "o.csv:2: '0x60' is no index of an object: 0x1000 to 0xFFFF"},
        {"index,name,type\n\n0x6000,,INT\n", "o.csv:3: object 0x6000 has no 'name'"},
        {"index,name,type\n0x6000,A,WHAT\n", "o.csv:2: 'type: WHAT' is none: BOOL"},
        {"index,name,type\n0x6000,A,\n", "o.csv:2: 'type' is missing: BOOL"},
        {"index,name,type\n0x6000,\xB5,INT\n", "o.csv:2: a character outside ISO 646 (ASCII) in 'name'"},
        {"index,name,type\n0x6000,A,INT\n0x6000,B,INT\n", "o.csv:3: object 6000 occurs twice, first in line 2"},
        {"index,subindex,name,type\n0x6000,1,A,INT\n", "o.csv:2: object 0x6000 has no name: write it to 'object'"},
        {"index,subindex,name,type,object\n-1,1,A,INT,R\n", "o.csv:2: '-1' is no index of an object: 0x1000 to 0xFFFF"},
        {"index,subindex,name,type,object\n0x6000,,A,INT,\n-1,1,B,INT,R\n", "o.csv:3: '-1' is no index of an object"},
        {"index,subindex,name,type,object\n0x6000,255,A,INT,R\n", "o.csv:2: 'subindex' takes a number from 0 to 254"},
        {"index,subindex,name,type,object\n0x6000,1,,INT,R\n", "o.csv:2: 'name' is missing"},
        {"index,subindex,name,type,object\n0x6000,1,A,INT,R\n0x6000,1,B,INT,\n",
         "o.csv:3: object 6000 has sub-index 1 twice: give one another 'subindex'"},
        {"index,subindex,name,type,object\n0x6000,1,A,INT,R\n0x6001,,B,INT,\n0x6000,2,C,INT,R\n",
         "o.csv:4: object 6000 occurs twice, first in line 2"},
        {"index,name,type,min\n0x6000,A,INT,5\n", "o.csv:2: the default 0 of 6000:0 is not within its limits 5 to"},
        {"index,name,type,pdo\n0x6000,A,INT,rx\n", "o.csv:2: 'pdo' takes in, out or nothing, not 'rx'"},
        {"index,name,type,pdo,access\n0x6000,A,INT,in,wo\n", "o.csv:2: 6000:0 is an input and cannot be read"},
        {"index,name,type,bits\n0x6000,A,INT,READY\n", "o.csv:2: 'bits' takes NUMBER=NAME, separated by ';'"},
        {"index,name,type,bits\n0x6000,A,INT,16=READY\n", "o.csv:2: '16' is no bit of 16"},
        {"index,name,type,values\n0x6000,A,INT,0=OFF\n", "o.csv:2: 'values' takes at least two"},
        {"index,name,type,values\n0x6000,A,REAL,0=A;1=B\n", "o.csv:2: 'values' is for integers: leave it out"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = try_device(DEVICE, rows[i].csv);
        const char *why = m.why + strlen(folder) + 1;
        if (m.twin != NULL || strncmp(why, rows[i].why, strlen(rows[i].why)) != 0)
            fail_msg("row %zu:\n%s\nexpected \"%s\", got \"%s\"", i, rows[i].csv, rows[i].why, m.why);
        drop(&m);
    }
}

static void a_table_is_beside_the_device_file_or_at_its_path(void **state)
{
    static const char begin[] = "ectwin-device: 1\nvendor: {id: 1, name: W}\nproduct: 1\ntype: G\nobjects: ";
    char yaml[TEXT];
    (void)state;
    (void)snprintf(yaml, sizeof yaml, "%s%s\ninputs: [0x6000]\n", begin, table_path);
    made_t m = make(yaml, "index,name,type\n0x6000,A,INT\n");
    assert_string_equal(entry_of(&m, 0x6000, 0)->name, "A");
    drop(&m);
    (void)snprintf(yaml, sizeof yaml, "%snone.csv\n", begin);
    m = made_of("g.yaml", yaml);
    assert_string_equal(
        m.why, "g.yaml:5: 'objects' takes objects, or the name of a table: none.csv: No such file or directory");
    drop(&m);
}

static void a_table_that_cannot_be_read_is_a_line_of_the_device_file(void **state)
{
    static const char zero[] = "index,name,type\n0x6000,A\0,INT\n";
    char expected[TEXT];
    (void)state;
    made_t m = try_device("ectwin-device: 1\nvendor: {id: 1, name: W}\nproduct: 1\ntype: G\nobjects: none.csv\n", "");
    (void)snprintf(expected, sizeof expected,
                   "%s:5: 'objects' takes objects, or the name of a table: %s/none.csv: No such file or directory",
                   device_path, folder);
    assert_string_equal(m.why, expected);
    write_table(zero, sizeof zero - 1);
    assert_null(ect_devfile_parse(device_path, DEVICE, strlen(DEVICE), m.why, sizeof m.why));
    assert_non_null(strstr(m.why, "o.csv:2: it contains a zero byte"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_is_an_entry_of_an_object),
        cmocka_unit_test(tables_of_office_programs_are_read),
        cmocka_unit_test(a_wrong_table_is_refused_with_its_line_and_a_cure),
        cmocka_unit_test(a_table_is_beside_the_device_file_or_at_its_path),
        cmocka_unit_test(a_table_that_cannot_be_read_is_a_line_of_the_device_file),
    };
    if (mkdtemp(folder) == NULL)
        return 1;
    (void)snprintf(table_path, sizeof table_path, "%s/o.csv", folder);
    (void)snprintf(device_path, sizeof device_path, "%s/g.yaml", folder);
    int status = cmocka_run_group_tests(tests, NULL, NULL);
    (void)unlink(table_path);
    (void)rmdir(folder);
    return status;
}
