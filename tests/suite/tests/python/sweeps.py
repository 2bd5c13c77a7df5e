"""Makes a sweep in shards: ``sweeps.py ENGINE MANIFEST SERVER [OPTION=VALUE…]``."""

import sys

import rusty

engine, manifest, server, *more = sys.argv[1:]
options = dict(option.split("=", 1) for option in more)
if engine == "kubernetes":
    print(rusty.kubernetes_job(manifest, image="lab:1", claim="data"))
    sys.exit()
if engine == "ray":
    import ray

    # Two workers that nobody else can reach.
    here = {"_node_ip_address": "127.0.0.1", "_temp_dir": options.pop("temp")}
    memory = {"object_store_memory": 80_000_000}
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, **here, **memory)
retries = int(options.pop("retries", 4))
try:
    parts = rusty.sweep(
        manifest, engine=engine, server=server, retries=retries, quiet=False, **options
    )
except rusty.LaunchError as error:
    print(error)
    sys.exit(10 + error.exit_code)
print(sum(part.is_file() for part in parts), "parts")
