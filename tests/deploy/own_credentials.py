"""Commands as an operator types them, and the certificates and tokens that they make."""

import subprocess
import sys


def shell(folder, command, stdin="", fails=False):
    """Runs a command as an operator types it, and prints it with its output. Returns the output."""
    print(f"$ {command}", flush=True)
    done = subprocess.run(command, shell=True, cwd=folder, input=stdin, text=True, capture_output=True, check=False)
    print(done.stdout + done.stderr, end="", flush=True)
    if (done.returncode != 0) != fails:
        sys.exit(f"failed: exit code {done.returncode}")
    return done.stdout


def make_credentials(folder):
    """ca.pem, server.pem and server.key for localhost, operator.token and reader.token, and tokens.toml."""
    shell(folder, "openssl req -x509 -newkey ed25519 -nodes -subj '/CN=Own CA' -days 30 -keyout ca.key -out ca.pem 2>/dev/null")
    shell(folder, "openssl req -newkey ed25519 -nodes -subj /CN=localhost -keyout server.key -out server.csr 2>/dev/null")
    shell(folder, "printf 'subjectAltName=DNS:localhost,IP:127.0.0.1' > names && openssl x509 -req -in server.csr -CA ca.pem "
                  "-CAkey ca.key -days 30 -extfile names -out server.pem 2>/dev/null")
    for name, role in (("operator", "admin"), ("reader", "read")):
        shell(folder, f"openssl rand -hex 32 > {name}.token")
        digest = shell(folder, f"tr -d '\\n' < {name}.token | openssl dgst -sha256 -r | cut -d' ' -f1").strip()
        with (folder / "tokens.toml").open("a") as tokens:
            tokens.write(f'[[token]]\nname = "{name}"\nsha256 = "{digest}"\nrole = "{role}"\nscenes = [""]\n')
    shell(folder, "cat tokens.toml")
