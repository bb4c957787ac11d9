"""What a hostile page, link, file or neighbour may send to the studio: refused, nothing written, nothing executed."""

import base64
import io
import re
import socket
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import browser
import helimag as hm
from fits import fit_of

missing = browser.lacking()
if missing is not None:
    pytest.skip(missing, allow_module_level=True)

from helimag.errors import HelimagError  # noqa: E402
from helimag.studio.intake import (  # noqa: E402
    link_of,
    run_from_bytes,
    scenario_from_bytes,
    scenario_from_link,
)

GOOD = hm.load("paper/fig3c").to_toml()
BODY = 'weight = { net_weight = "1 uN", gravity_center = "0 mm" }'
FILES = ("/etc/passwd", "../../etc/passwd", "C:\\\\Windows\\\\win.ini", "file:///etc/passwd", "//elsewhere/share/x.stl")


def linked(text):
    return base64.urlsafe_b64encode(zlib.compress(text)).decode().rstrip("=")


def with_body(name):
    head = GOOD.split("[device]")[0]
    return head + f'[device]\nmagnetic_moment = "6e-4 A m^2"\n{BODY}\nbody = {{ file = "{name}", unit = "mm" }}\n'


HOSTILE_SCENARIOS = {
    "empty": b"",
    "not text": b"\xff\xfe\x00\x01",
    "not TOML": b"<script>alert(1)</script>",
    "huge": b'name = "' + b"x" * 2**20 + b'"',
    "deep lists": b"a = " + b"[" * 4000 + b"]" * 4000,
    "deep tables": ("a = " + "{b = " * 300 + "1" + "}" * 300).encode(),
    "an integer of a million digits": b"a = " + b"9" * 200_000,
    "unknown keys": GOOD.encode() + b'\n[__proto__]\nadmin = "yes"\n',
    "not finite": GOOD.replace('frequency = "3.3 Hz"', 'frequency = "inf Hz"').encode(),
    "a run of a year": GOOD.replace('duration = "1800 s"', 'duration = "3e7 s"').encode(),
    "half a day of slow turns": GOOD.replace('duration = "1800 s"', 'duration = "40000 s"')
    .replace('frequency = "3.3 Hz"', 'frequency = "0.5 Hz"')
    .encode(),
    "a billion samples": GOOD.replace('duration = "1800 s"', 'duration = "1800 s"\ninterval = "0.001 s"').encode(),
    "a billion turns": GOOD.replace('frequency = "3.3 Hz"', 'frequency = "1e6 Hz"').encode(),
    **{f"names the file {name}": with_body(name).encode() for name in FILES},
}


@pytest.mark.parametrize("content", HOSTILE_SCENARIOS.values(), ids=HOSTILE_SCENARIOS)
def test_a_hostile_scenario_is_refused(content):
    with pytest.raises(HelimagError) as refusal:
        scenario_from_bytes(content)
    assert len(str(refusal.value)) < 600
    assert "root:" not in str(refusal.value)


@pytest.mark.parametrize("name", FILES)
def test_no_link_names_a_file(name):
    with pytest.raises(HelimagError, match="must not name a file"):
        scenario_from_link(linked(with_body(name).encode()))


# numbers that no device, no oil and no run has, each in an otherwise good scenario
NO_NUMBERS = {
    f"{what} {value}": linked(
        re.sub(rf'^{what} = "[0-9.]+ ', f'{what} = "{value} ', GOOD, count=1, flags=re.M).encode()
    )
    for what in ("frequency", "viscosity", "distance", "duration", "magnetic_moment", "radius")
    for value in ("nan", "inf", "-inf", "1e308", "-1e308", "1e400")
}


@pytest.mark.parametrize("link", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_a_link_of_no_numbers_has_no_run(link):
    """It is refused, or its run says that its numbers broke down."""
    with pytest.raises(HelimagError) as refusal:
        hm.simulate(scenario_from_link(link), duration="1 s")
    assert len(str(refusal.value)) < 600


HOSTILE_LINKS = {
    "nothing": "",
    "not base64": "../../etc/passwd",
    "markup": "<script>alert(1)</script>",
    "not compressed": base64.urlsafe_b64encode(b"name = 1").decode(),
    "a bomb": linked(b"#" * 200_000_000),
    "cut short": link_of(hm.load("paper/fig3c"))[:-40],
    "not text": linked(b"\xff\xff"),
}


@pytest.mark.parametrize("link", HOSTILE_LINKS.values(), ids=HOSTILE_LINKS)
def test_a_hostile_link_is_refused(link):
    with pytest.raises(HelimagError):
        scenario_from_link(link)


def test_a_bomb_is_not_unpacked():
    with pytest.raises(HelimagError, match="its scenario does not end"):
        scenario_from_link(HOSTILE_LINKS["a bomb"])


def test_a_good_file_and_link_are_taken():
    scenario = hm.load("paper/fig3c")
    assert scenario_from_bytes(GOOD.encode()) == scenario
    assert scenario_from_link(link_of(scenario)) == scenario


def bomb():
    """HDF5 that claims to hold far more numbers than it has bytes."""
    import h5netcdf

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        file.dimensions = {"time": 10**9}
        file.create_variable("position", ("time",), "f8", chunks=(10**6,))
    return content.getvalue()


HOSTILE_RUNS = {
    "not netCDF": (".nc", b"not netCDF"),
    "a bomb": (".nc", bomb()),
    "another suffix": (".py", b"import os"),
    "a path as suffix": ("/../../x.nc", b""),
    "huge": (".nc", b"\x89HDF" + b"0" * (17 * 2**20)),
    "no table": (".csv", b"\x00\x01\x02"),
    "a formula": (".csv", b"time [s],x [mm],y [mm],z [mm]\n=cmd|' /C calc'!A0,1,1,1\n1,1,1,1\n"),
}


@pytest.mark.parametrize(("suffix", "content"), HOSTILE_RUNS.values(), ids=HOSTILE_RUNS)
def test_a_hostile_run_is_refused(suffix, content, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(HelimagError) as refusal:
        run_from_bytes(content, suffix, 0.15)
    assert list(tmp_path.iterdir()) == []
    assert str(tmp_path) not in str(refusal.value)


def said(port, request, *, rest=b""):
    """Send raw bytes: status and body of the answer; status 0 where the connection is just closed."""
    with socket.create_connection(("127.0.0.1", port), timeout=20.0) as wire:
        try:
            wire.sendall(request.encode("latin-1") + rest)
            answer = b""
            while len(answer) < 2**16 and (part := wire.recv(2**14)):
                answer += part
        except ConnectionError:
            return 0, b""
    if not answer:
        return 0, b""
    return int(answer.split(b" ", 2)[1]), answer.partition(b"\r\n\r\n")[2]


def asked(path, port, *, method="GET", host=None, more=""):
    name = host or f"127.0.0.1:{port}"
    return f"{method} {path} HTTP/1.1\r\nHost: {name}\r\nConnection: close\r\n{more}\r\n"


UPGRADE = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: x3JJHMbDL1EzLkh9GBhXDw==\r\nSec-WebSocket-Version: 13\r\n"
)
UPLOAD = "/_nicegui/client/x/upload/1"
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"


@pytest.fixture(scope="module")
def open_port(tmp_path_factory):
    """A studio on this machine only, and its folder."""
    folder = tmp_path_factory.mktemp("open")
    with browser.served(folder=folder) as address:
        yield int(address.split(":")[2].rstrip("/")), folder


ROUTE = "/studio/picture"  # the one place that gives content by a name in its address
UNKNOWN = (
    *(
        f"{ROUTE}/x/{w}"
        for w in ("live", "0", "-1", "1e3", "999999", "%D9%A3", "%C2%B2", "live%00", "live%0d%0aX:%20y")
    ),
    *(
        f"{ROUTE}/{k}/live"
        for k in ("%00", "%2e%2e", "..", "%F0%9F%98%80", "'%20or%201=1", "A" * 8000, "*", "__proto__")
    ),
    f"{ROUTE}/x/live?" + "q=" * 8000,
    f"{ROUTE}/x",
    f"{ROUTE}//live",
    f"{ROUTE}/x/live/",
)


@pytest.mark.parametrize("path", UNKNOWN)
def test_no_guessed_name_gives_content(open_port, path):
    status, body = said(open_port[0], asked(path, open_port[0]))
    assert status in {307, 400, 404}
    assert b"Traceback" not in body
    assert str(Path(hm.__file__).parent).encode() not in body


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "TRACE", "BREW"])
def test_content_is_fetched_and_not_changed(open_port, method):
    port, folder = open_port
    more = f"Origin: http://127.0.0.1:{port}\r\nContent-Length: 0\r\n"
    status, _ = said(port, asked(f"{ROUTE}/x/live", port, method=method, more=more))
    assert status in {400, 404, 405}
    assert list(folder.iterdir()) == []


def test_many_who_guess_at_once_keep_nobody_out(open_port):
    port, _ = open_port
    with ThreadPoolExecutor(16) as pool:
        found = list(pool.map(lambda i: said(port, asked(f"{ROUTE}/{i}/live", port))[0], range(200)))
    assert set(found) == {404}
    assert said(port, asked("/", port))[0] == 200


TRAVERSALS = (
    "/../../../../etc/passwd",
    "/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
    "/_nicegui/3.18.0/static/../../../../../../etc/passwd",
    "/_nicegui/3.18.0/static/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
    "/_nicegui/3.18.0/esm/x/..%2f..%2f..%2fetc/passwd",
    "/studio/picture/..%2f..%2fetc/passwd",
    "/studio/picture/x/../../../etc/passwd",
    "/studio/picture/x/-1",
)


@pytest.mark.parametrize("path", TRAVERSALS)
def test_no_address_leads_to_a_file(open_port, path):
    status, body = said(open_port[0], asked(path, open_port[0]))
    assert status in {400, 403, 404}
    assert b"root:" not in body


REFUSED = {
    "another host": (421, {"path": "/", "host": "evil.example"}, ""),
    "a host that ends alike": (421, {"path": "/", "host": "localhost.evil.example"}, ""),
    "another origin posts": (403, {"path": UPLOAD, "method": "POST"}, "Origin: http://evil.example\r\n"),
    "nobody's origin posts": (403, {"path": UPLOAD, "method": "POST"}, ""),
    "a page in a sandbox": (403, {"path": "/", "method": "POST"}, "Origin: null\r\n"),
    "another origin's websocket": (403, {"path": SOCKET}, UPGRADE + "Origin: http://evil.example\r\n"),
    "a websocket of no origin": (403, {"path": SOCKET}, UPGRADE),
    "another origin polls": (403, {"path": SOCKET.replace("websocket", "polling")}, "Origin: https://evil.example\r\n"),
    "a very long address": (414, {"path": "/?s=" + "A" * 40_000}, ""),
    "a gigabyte": (413, {"path": "/", "method": "POST"}, "Content-Length: 1073741824\r\n"),
    "less than nothing": (400, {"path": "/", "method": "POST"}, "Content-Length: -5\r\n"),
    "two hosts": (400, {"path": "/", "host": "evil.example"}, "Host: 127.0.0.1:{port}\r\n"),
    "two origins": (400, {"path": UPLOAD, "method": "POST"}, "Origin: http://evil.example\r\nOrigin: {own}\r\n"),
    "a host without its port": (421, {"path": "/", "host": "127.0.0.1"}, ""),
    "a host that resolves to here": (421, {"path": "/", "host": "127.0.0.1.rebind.example:{port}"}, ""),
    "this machine by another name": (421, {"path": "/", "host": "0.0.0.0:{port}"}, ""),
    "a host that is markup": (421, {"path": "/", "host": "<script>"}, ""),
    "the same name at another port": (403, {"path": SOCKET}, UPGRADE + "Origin: http://127.0.0.1:1\r\n"),
    "a file's websocket": (403, {"path": SOCKET}, UPGRADE + "Origin: null\r\n"),
    "deletes": (403, {"path": "/", "method": "DELETE"}, "Origin: http://evil.example\r\n"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_request_that_is_not_ours_is_refused(open_port, name):
    status, given, more = REFUSED[name]
    port, _ = open_port
    method, host = given.get("method", "GET"), given.get("host")
    known = {"port": port, "own": f"http://127.0.0.1:{port}"}
    request = asked(given["path"], port, method=method, host=host and host.format(**known), more=more.format(**known))
    found, body = said(port, request)
    assert found == status
    assert b"passwd" not in body


def test_a_body_of_no_stated_length_ends_at_the_limit(open_port):
    port, folder = open_port
    head = asked("/", port, method="POST", more=f"Origin: http://127.0.0.1:{port}\r\nTransfer-Encoding: chunked\r\n")
    chunk = b"100000\r\n" + b"x" * 2**20 + b"\r\n"
    status, _ = said(port, head, rest=chunk * 30)
    assert status in {0, 400, 405, 413}
    assert list(folder.iterdir()) == []


def test_many_that_say_nothing_keep_nobody_out(open_port):
    """Connections left open, half a request in each: the next is still answered."""
    port, _ = open_port
    idle = []
    try:
        for i in range(150):
            idle.append(socket.create_connection(("127.0.0.1", port), timeout=10.0))
            idle[-1].sendall(b"GET / HTTP/1.1\r\nHost: " + b"x" * (i % 7))
        assert said(port, asked("/", port))[0] == 200
    finally:
        for wire in idle:
            wire.close()


def test_our_own_page_is_answered(open_port):
    port, folder = open_port
    status, body = said(port, asked("/", port))
    assert status == 200
    assert b"helimag studio" in body
    assert list(folder.iterdir()) == []


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    """A studio that other machines can reach: port and token."""
    with browser.served("--host", "0.0.0.0", folder=tmp_path_factory.mktemp("guarded")) as address:
        place, token = address.split("/?token=")
        yield int(place.split(":")[2]), token


@pytest.mark.parametrize(
    ("path", "more"),
    [
        ("/", ""),
        ("/?token=", ""),
        ("/?token=wrong", ""),
        ("/", "Cookie: helimag-studio=wrong\r\n"),
        ("/", "Cookie: helimag-studio=\r\n"),
        ("/studio/picture/x/live", ""),
        (SOCKET, UPGRADE + "Origin: http://127.0.0.1:{port}\r\n"),
        (SOCKET + "&token={token}", UPGRADE + "Origin: http://127.0.0.1:{port}\r\n"),
    ],
)
def test_without_the_token_nobody_comes_in(guarded, path, more):
    port, token = guarded
    path, more = (text.format(port=port, token=token) for text in (path, more))
    status, body = said(port, asked(path, port, more=more))
    assert status in {401, 403}
    assert b"<html" not in body


def test_with_the_token_one_comes_in(guarded):
    port, token = guarded
    status, _ = said(port, asked(f"/?token={token}", port))
    assert status == 303
    status, body = said(port, asked("/", port, more=f"Cookie: helimag-studio={token}\r\n"))
    assert status == 200
    assert token.encode() not in body


@pytest.mark.parametrize(
    "path", ["/%0d%0aSet-Cookie:%20a=b", "//evil.example/", "/%5cevil.example/", "/%2f%2fevil.example"]
)
def test_the_token_leads_nowhere_else(guarded, path):
    """No line's end gets into the answer's head, and the place that it names is one of this server's."""
    port, token = guarded
    with socket.create_connection(("127.0.0.1", port), timeout=20.0) as wire:
        wire.sendall(asked(f"{path}?token={token}", port).encode())
        head = wire.recv(2**16).partition(b"\r\n\r\n")[0].split(b"\r\n")
    assert sum(line.lower().startswith(b"set-cookie:") for line in head) == 1
    (place,) = (line.split(b": ", 1)[1] for line in head if line.lower().startswith(b"location:"))
    assert place.startswith(b"/")
    assert place[1:2] not in {b"/", b"\\"}


SCRIPT = "<img src=x onerror=window.hurt=1><script>window.hurt=1</script>"


def scripted(tmp_path, image):
    """Files with script where a message or a list repeats it: where it goes, its suffix, content, and what is told."""
    run = hm.simulate(hm.load("paper/fig3c"), duration="20 s")
    run.dataset.attrs |= {"name": SCRIPT, "source": SCRIPT, "frames": SCRIPT, "end": "horizon", "versions": SCRIPT}
    run.save(tmp_path / "scripted.nc")
    fit_of(hm.load("paper/fig3c"), title=SCRIPT).save(tmp_path / "fit.nc")
    heading = GOOD.replace('heading = "helix"', f'heading = "{SCRIPT}"')
    assert SCRIPT in heading
    return {
        "a word": (("upload-scenario", ""), "toml", heading.encode(), f"got '{image}"),
        "a key": (("upload-scenario", ""), "toml", f'"{image}" = 1\n{GOOD}'.encode(), image),
        "a column": (
            ("upload-run", "compare"),
            "csv",
            f"time [s],x [mm],y [mm],{image}\n0,1,1,1\n1,1,1,1\n".encode(),
            f"it lacks z; its heads are 'time [s]', 'x [mm]', 'y [mm]', '{image}'",
        ),
        "attributes": (("upload-run", "compare"), "nc", (tmp_path / "scripted.nc").read_bytes(), "attributes.nc"),
        "a fit": (("upload-calibration", "ensemble"), "nc", (tmp_path / "fit.nc").read_bytes(), SCRIPT[:60]),
    }


def test_no_name_is_markup(open_port, tmp_path):
    """Script in every string that a scenario, a run and a file can have is shown as it is written."""
    port, _ = open_port
    marks = f'"drive.pitch" = "measured: {SCRIPT}"'
    named = GOOD.replace('name = "paper/fig3c"', f'name = "{SCRIPT}"')
    text = named.split("[provenance]")[0] + f"[provenance]\n{marks}\n"
    scenario = scenario_from_bytes(text.encode())
    run = hm.simulate(scenario, duration=100.0)
    run.save(tmp_path / "run.nc")
    with browser.chromium() as chromium:
        page = chromium.new_page()
        page.set_default_timeout(150_000)
        page.on("dialog", lambda dialog: pytest.fail(f"a script ran: {dialog.message}"))
        page.goto(f"http://localhost:{port}/?s={link_of(scenario)}")
        whole = '[data-testid="verdict"][data-stage="AFTERWARDS"]'
        page.wait_for_selector(whole)
        page.click('[data-testid="tab-compare"]')
        page.click('[data-testid="pin"]')
        upload = '[data-testid="upload-run"] input[type=file]'
        content = (tmp_path / "run.nc").read_bytes()
        image = SCRIPT.partition("<script>")[0]  # without a slash, from which on a name is a path's last part
        page.set_input_files(upload, {"name": f"{image}.nc", "mimeType": "x", "buffer": content})
        page.wait_for_selector(f'[data-testid="compared"] >> text={image}.nc')
        for name, (upload, suffix, hostile, told) in scripted(tmp_path, image).items():
            page.click(f'[data-testid="tab-{upload[1]}"]') if upload[1] else None
            chosen = {"name": f"{name}.{suffix}", "mimeType": "x", "buffer": hostile}
            page.set_input_files(f'[data-testid="{upload[0]}"] input[type=file]', chosen)
            page.wait_for_function("text => document.body.innerText.includes(text)", arg=told)
            assert page.evaluate("window.hurt") is None, name
        page.goto(f"http://localhost:{port}/?s={SCRIPT}")
        page.wait_for_selector("text=the link is damaged")
        page.wait_for_selector(whole)
        assert page.evaluate("window.hurt") is None


def test_the_page_keeps_to_itself(open_port):
    """Its headers allow no other host, no frame around it and no guessing of types."""
    port, _ = open_port
    with socket.create_connection(("127.0.0.1", port), timeout=20.0) as wire:
        wire.sendall(asked("/", port).encode())
        head = wire.recv(2**16).partition(b"\r\n\r\n")[0].lower()
    assert b"default-src 'self'" in head
    assert b"frame-ancestors 'none'" in head
    assert b"nosniff" in head


def test_the_port_may_be_taken(helimag, open_port):
    status, _, err = helimag("studio", "--port", open_port[0], "--no-browser")
    assert status == 2
    assert f"--port {open_port[0]} cannot be used" in err
